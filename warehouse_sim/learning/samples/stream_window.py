"""The latest items of a stream, as the steps of training draw from them."""

from collections import deque
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Generic, TypeVar

from warehouse_sim.errors import TrainingError

Item = TypeVar("Item")
Made = TypeVar("Made")
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
