"""The latest items of a stream, as a step of training draws from them."""

from collections import deque
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Generic, TypeVar

from warehouse_sim.errors import TrainingError

Item = TypeVar("Item")
Made = TypeVar("Made")


class StreamWindow(Generic[Item, Made]):
    """A window that moves along a stream of numbered items: where it is depends on the step alone.

    Args:
        open_stream: Gives the items from a number on.
        make: Makes of an item what is kept.
        size: Items in the window, >= 1.
        fresh: Items that each step brings in, >= 0.
    """

    def __init__(
        self, open_stream: Callable[[int], Iterator[Item]], make: Callable[[Item], Made], size: int, fresh: float
    ) -> None:
        self._open, self._make, self._size, self._fresh = open_stream, make, size, fresh
        self._items: deque[Made] = deque(maxlen=size)
        self._stream: Iterator[Item] = iter(())
        self._end = -1
        """Number of the first item that is yet to come; below 0 before the stream is opened."""

    def first(self, step: int) -> int:
        """Return the number of the oldest item in the window of a step."""
        return int(step * self._fresh)

    def at(self, step: int) -> list[Made]:
        """Return the window of a step, oldest first, once the stream has come so far.

        Raises:
            TrainingError: The stream ends before.
        """
        first = self.first(step)
        if self._end < 0 or first + self._size < self._end or first > self._end:
            self._stream, self._end = self._open(first), first
            self._items.clear()
        last = first + self._size
        for item in islice(self._stream, last - self._end):
            self._items.append(self._make(item))
            self._end += 1
        if self._end < last:
            raise TrainingError(f"the stream ends before observation {self._end}, which step {step} needs")
        return list(self._items)
