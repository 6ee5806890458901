"""How long a training waits for the stream that feeds it."""

import time
from collections.abc import Generator, Iterator
from itertools import count
from typing import TYPE_CHECKING

from warehouse_sim.learning.settings import Progress, StreamConfig
from warehouse_sim.learning.trainable import OpenStream

if TYPE_CHECKING:
    from warehouse_sim.schema import Observation


class AwaitedStream:
    """A stream as it is, which counts the seconds that its observations are waited for.

    Args:
        open_stream: Gives the observations.
        progress: Called while the first window fills.
    """

    def __init__(self, open_stream: OpenStream, progress: Progress | None = None) -> None:
        self._open, self._progress = open_stream, progress
        self.filling_s = 0.0
        """Until windows were full at the beginning (s)."""
        self._waited_s, self._full = 0.0, 0.0
        self._stream: Iterator[Observation] = iter(())

    def __call__(self, config: StreamConfig, start: int) -> "Iterator[Observation]":
        """Yield the observations of a stream from a number on."""
        self.close()
        self._stream = stream = self._open(config, start)
        for taken in count():
            if taken < config.window and self._progress:
                self._progress(0.0, f"observation {taken + 1} of {config.window} of the stream's first window")
            began = time.monotonic()
            item = next(stream, None)
            now = time.monotonic()
            if item is None:
                return
            if taken < config.window:
                self.filling_s, self._waited_s, self._full = self.filling_s + now - began, 0.0, now
            else:
                self._waited_s += now - began
            yield item

    def close(self) -> None:
        """End what makes observations, which would else go on until the last reference to it is gone."""
        if isinstance(self._stream, Generator):
            self._stream.close()

    def fraction(self) -> float:
        """Return the fraction of the time since the window was full that steps waited, 0-1."""
        return self._waited_s / max(time.monotonic() - self._full, 1e-9)
