"""Make the samples of a step in threads, and those of the next one while the network works on this."""

from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Made = TypeVar("Made")


class MadeAhead(Generic[Key, Made]):
    """What keys stand for, made by threads.

    What is made depends on its key alone, so that neither the number of threads nor a wrong guess of what comes next
    changes it: what was guessed and is not requested is thrown away.

    Args:
        make: Makes what a key stands for; called in several threads at once.
        workers: Threads; 1 makes everything when it is requested, in the thread that asks.
    """

    def __init__(self, make: Callable[[Key], Made], workers: int) -> None:
        self._make = make
        self._pool = ThreadPoolExecutor(workers, "sample") if workers > 1 else None
        self._begun: dict[Key, Future[Made]] = {}

    def take(self, keys: Sequence[Key], following: Sequence[Key] = ()) -> list[Made]:
        """Return what ``keys`` stand for, in their order, and begin to make what probably is requested next."""
        if self._pool is None:
            return [self._make(key) for key in keys]
        begun, self._begun = self._begun, {}
        futures = [begun.pop(key) if key in begun else self._pool.submit(self._make, key) for key in keys]
        for wrong in begun.values():
            wrong.cancel()
        made = [future.result() for future in futures]
        # Only now: while this step is waited for, nothing else shall take its threads.
        self._begun = {key: self._pool.submit(self._make, key) for key in following}
        return made
