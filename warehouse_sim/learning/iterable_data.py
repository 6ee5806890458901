"""Anything that can be iterated, as torch's loaders take it."""

from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any

from torch.utils.data import IterableDataset, get_worker_info


class IterableData(IterableDataset[Any]):
    """Items of an iterable, such as a stream of observations, made into samples one by one.

    Args:
        items: Anything that can be iterated; once for each epoch.
        sample: Turns an item into what a batch is collated of.
    """

    def __init__(self, items: Iterable[Any], sample: Callable[[Any], Any] = lambda item: item) -> None:
        self._items, self._sample = items, sample

    def __iter__(self) -> Iterator[Any]:
        """Yield samples; of n workers of a loader, each yields every n-th item and passes over the others."""
        worker = get_worker_info()
        items = self._items if worker is None else islice(self._items, worker.id, None, worker.num_workers)
        return map(self._sample, items)
