"""A stream that is timed gives what it gives, and says how long steps waited: by a clock that only the test turns."""

from collections.abc import Iterator

import pytest

from warehouse_sim.learning.samples import awaited
from warehouse_sim.learning.samples.awaited import AwaitedStream
from warehouse_sim.learning.settings import StreamConfig


class Turned:
    """A clock; making an item takes 3 s of it."""

    def __init__(self) -> None:
        self.now, self.closed = 100.0, 0

    def monotonic(self) -> float:
        return self.now

    def stream(self, config: StreamConfig, start: int) -> Iterator:
        try:
            for number in range(start, 10):
                self.now += 3.0
                yield number
        finally:
            self.closed += 1


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Turned:
    turned = Turned()
    monkeypatch.setattr(awaited, "time", turned)
    return turned


def test_waiting_is_counted_once_the_window_is_full(clock: Turned) -> None:
    said: list[str] = []
    stream = AwaitedStream(clock.stream, lambda fraction, note: said.append(note))
    items = stream(StreamConfig("toy", window=2), 5)
    assert [next(items), next(items)] == [5, 6]
    clock.now += 9.0  # steps
    assert (stream.filling_s, stream.fraction()) == (6.0, 0.0)
    assert next(items) == 7
    assert stream.fraction() == pytest.approx(3.0 / 12.0)
    assert said == [f"observation {number} of 2 of the stream's first window" for number in (1, 2)]


def test_a_stream_that_is_opened_again_fills_again(clock: Turned) -> None:
    stream = AwaitedStream(clock.stream)
    first = stream(StreamConfig("toy", window=2), 0)
    assert [next(first) for _ in range(4)] == [0, 1, 2, 3]
    again = stream(StreamConfig("toy", window=2), 8)
    assert next(again) == 8
    assert clock.closed == 1  # its makers end, though somebody still holds it
    assert next(again) == 9
    assert (stream.filling_s, stream.fraction()) == (12.0, 0.0)
    stream.close()
    assert clock.closed == 2
    assert list(again) == list(first) == []
