"""Any sequence as a map-style dataset of torch, and anything that can be iterated as an iterable one."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any

import numpy as np
import torch
from torch.utils.data import Dataset, IterableDataset, get_worker_info

Arrays = Mapping[str, np.ndarray[Any, Any] | int]


class TorchData(Dataset[dict[str, Any]]):
    """What a loader of torch reads; its own collation makes batches of it, and worker processes may read it.

    Args:
        items: Any sequence.
        read: Turns an item into arrays, whose shapes are the same for all items, and whole numbers.
    """

    def __init__(self, items: Sequence[Any], read: Callable[[Any], Arrays]) -> None:
        self._items, self._read = items, read

    def __len__(self) -> int:
        return len(self._items)

    def __getitem__(self, index: int) -> dict[str, Any]:
        """Return the tensors and numbers of one item."""
        found = self._read(self._items[index])
        return {
            name: torch.from_numpy(np.ascontiguousarray(value)) if isinstance(value, np.ndarray) else value
            for name, value in found.items()
        }


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
