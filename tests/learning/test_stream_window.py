"""A window that moves along a stream is where the step says, whatever came before, and says how long steps waited."""

from collections.abc import Iterator
from itertools import count

import pytest

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.samples import stream_window
from warehouse_sim.learning.samples.stream_window import AwaitedStream, StreamWindow
from warehouse_sim.learning.settings import StreamConfig


def window(fresh: float, opened: list[int], made: list[int], size: int = 4) -> StreamWindow[int, int]:
    def open_stream(start: int) -> Iterator[int]:
        opened.append(start)
        return count(start)

    def make(item: int) -> int:
        made.append(item)
        return item

    return StreamWindow(open_stream, make, size, fresh)


@pytest.mark.parametrize(
    ("fresh", "step", "first"), [(0.0, 9, 0), (0.25, 3, 0), (0.25, 9, 2), (1.0, 9, 9), (7.0, 9, 63)]
)
def test_a_step_sees_the_same_whether_steps_were_taken_before_it_or_not(fresh: float, step: int, first: int) -> None:
    walked = window(fresh, [], [])
    for before in range(step):
        walked.at(before)
    expected = list(range(first, first + 4))
    assert walked.at(step) == window(fresh, [], []).at(step) == expected


@pytest.mark.parametrize(("fresh", "size", "stay"), [(0.05, 18, 45), (0.25, 256, 128), (2.0, 32, 2), (2.0, 16, 1)])
def test_a_window_moves_by_an_eighth_of_its_size_at_once(fresh: float, size: int, stay: int) -> None:
    made: list[int] = []
    moving = window(fresh, [], made, size)
    shown = [moving.at(step) for step in range(3 * stay)]
    assert [moving.arrived(step) for step in range(3 * stay)] == sorted([0, stay, 2 * stay] * stay)
    for step, items in enumerate(shown):
        first = int(moving.arrived(step) * fresh)
        assert items == list(range(first, first + size))
    entered = len(set(shown[-1]) - set(shown[0])) / 2
    assert size / 8 - fresh - 1 < entered <= max(size / 8, fresh)


def test_items_are_made_evenly_though_the_window_strides() -> None:
    made: list[int] = []
    moving = window(0.5, [], made, 80)  # strides of 20 steps
    for step in range(100):
        moving.at(step)
        assert made == list(range(80 + step // 2))
    # In the middle of a stride, only what the window shows and what waits is regenerated.
    again: list[int] = []
    assert window(0.5, [], again, 80).at(70) == moving.at(70) == list(range(30, 110))
    assert again == list(range(30, 115))


def test_a_resumed_window_makes_what_it_holds_and_no_more() -> None:
    opened: list[int] = []
    made: list[int] = []
    resumed = window(0.5, opened, made)
    assert resumed.at(100) == made == [50, 51, 52, 53]
    assert resumed.at(2) == [1, 2, 3, 4]
    assert opened == [50, 1]


def test_a_stream_that_ends_is_named() -> None:
    short = StreamWindow(lambda start: iter(range(start, 6)), lambda item: item, 4, 1.0)
    assert short.at(2) == [2, 3, 4, 5]
    with pytest.raises(TrainingError, match="the stream ends before observation 6, which step 3 needs"):
        short.at(3)


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
    monkeypatch.setattr(stream_window, "time", turned)
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
