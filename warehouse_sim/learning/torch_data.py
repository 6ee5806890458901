"""Any sequence as a map-style dataset of torch, each item a dict of tensors of the same shapes."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch.utils.data import Dataset

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
