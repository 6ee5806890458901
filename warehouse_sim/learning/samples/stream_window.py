"""A stream that feeds a training: its latest items, as steps draw from them, and how long these wait for it."""

import time
from collections import deque
from collections.abc import Callable, Generator, Iterator
from itertools import count, islice
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.settings import Progress, StreamConfig
from warehouse_sim.learning.trainable import OpenStream

if TYPE_CHECKING:
    from warehouse_sim.schema import Observation

Item = TypeVar("Item")
Made = TypeVar("Made")
Held = TypeVar("Held")
_STRIDES = 8
"""Strides in which a window passes an item."""


class StreamWindow(Generic[Item, Made]):
    """A window that moves along a stream of numbered items: where it is depends on the step alone.

    It moves by strides of an eighth of its size, and stays where it is for the steps that bring in so many items, so
    that these can go round what it shows. Items are made evenly over the steps and wait for the next stride.

    Args:
        open_stream: Gives the items from a number on.
        make: Makes of an item what is kept.
        size: Items in the window, >= 1; up to an eighth more wait.
        fresh: Items that each step brings in, >= 0; where that is more than an eighth, each step is a stride.
    """

    def __init__(
        self, open_stream: Callable[[int], Iterator[Item]], make: Callable[[Item], Made], size: int, fresh: float
    ) -> None:
        self._open, self._make, self._size, self._fresh = open_stream, make, size, fresh
        self._stay = max(1, int(size / (_STRIDES * fresh))) if fresh > 0 else 0
        self._items: deque[Made] = deque()
        self._stream: Iterator[Item] = iter(())
        self._oldest = self._end = -1
        """Numbers of the oldest item that is kept, and of the first that is yet to come; below 0 before there are."""

    def arrived(self, step: int) -> int:
        """Return the step at which the window came to where it is at a step."""
        return step - step % self._stay if self._stay else 0

    def first(self, step: int) -> int:
        """Return the number of the oldest item in the window of a step."""
        return int(self.arrived(step) * self._fresh)

    def at(self, step: int) -> list[Made]:
        """Return the window of a step, oldest first, once the stream has come so far.

        Raises:
            TrainingError: The stream ends before.
        """
        first, last = self.first(step), int(step * self._fresh) + self._size
        if self._end < 0 or first < self._oldest or first > self._end:
            self._stream, self._oldest, self._end = self._open(first), first, first
            self._items.clear()
        while self._oldest < first:
            self._items.popleft()
            self._oldest += 1
        for item in islice(self._stream, max(0, last - self._end)):
            self._items.append(self._make(item))
            self._end += 1
        if self._end < last:
            raise TrainingError(f"the stream ends before observation {self._end}, which step {step} needs")
        return list(islice(self._items, self._size))


class Arrivals(Generic[Made, Held]):
    """What steps draw from while a window moves: gathered when it comes to another place, kept until the next one.

    Args:
        window: The window.
        gather: Makes of what it shows, and of the step at which it came there, what is drawn from.
    """

    def __init__(self, window: StreamWindow[Item, Made], gather: Callable[[list[Made], int], Held]) -> None:
        self._window, self._gather = window, gather
        self._held: dict[int, Held] = {}

    def at(self, step: int) -> tuple[int, Held]:
        """Return when the window came to where it is at a step, and what is drawn from there.

        Raises:
            TrainingError: The stream ends before.
        """
        arrived, shown = self._window.arrived(step), self._window.at(step)
        if arrived not in self._held:
            # Samples of the step before may still be composed.
            before = {place: held for place, held in self._held.items() if place == max(self._held)}
            self._held = before | {arrived: self._gather(shown, arrived)}
        return arrived, self._held[arrived]

    def since(self, arrived: int) -> Held:
        """Return what is drawn from since a step, the last one or the one before at which the window came."""
        return self._held[arrived]


def window_of(
    open_stream: OpenStream | None, config: StreamConfig, make: Callable[["Observation"], Made]
) -> StreamWindow["Observation", Made]:
    """Return the window of the stream that settings name.

    Args:
        open_stream: Gives the observations.
        config: Which stream, and how much of it is kept.
        make: Makes of an observation what is kept.

    Raises:
        TrainingError: Nothing opens the stream.
    """
    if open_stream is None:
        raise TrainingError(f"nothing here opens the stream of {config.recipe}: give train() one")
    return StreamWindow(lambda start: open_stream(config, start), make, config.window, config.fresh)


def seed_since(seed: int, arrived: int) -> int:
    """Return the seed of the order that begins where a window came to at a step; the first is that of the run."""
    return int(np.random.default_rng([seed, arrived]).integers(2**31)) if arrived else seed


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
