"""Rows of several arrays as one array: read where they lie, for nothing is copied."""

from collections.abc import Sequence
from typing import cast

import numpy as np

from warehouse_sim.learning.samples.array_store import Arrays


class JoinedRows:
    """The rows of arrays of one row shape and type, end to end.

    Args:
        parts: Arrays, each with rows.

    Raises:
        ValueError: Their rows differ in shape or type.
    """

    def __init__(self, parts: Sequence[np.ndarray]) -> None:
        kinds = {(part.shape[1:], part.dtype) for part in parts}
        if len(kinds) != 1:
            raise ValueError(f"rows of one shape and type expected, found {sorted(map(str, kinds))}")
        self._parts = list(parts)
        self._ends = np.cumsum([len(part) for part in parts])

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of rows, and the shape of one."""
        return int(self._ends[-1]), *self._parts[0].shape[1:]

    def __len__(self) -> int:
        return int(self._ends[-1])

    def __getitem__(self, row: int) -> np.ndarray:
        """Return a row.

        Raises:
            IndexError: There is none of this number.
        """
        if not 0 <= row < len(self):
            raise IndexError(f"row {row} of {len(self)}")
        part = int(np.searchsorted(self._ends, row, side="right"))
        found: np.ndarray = self._parts[part][row - int(self._ends[part]) + len(self._parts[part])]
        return found


def joined_alike(parts: Sequence[Arrays], whole: Sequence[str]) -> list[Arrays]:
    """Return the arrays of parts whose rows are alike as one each, in the order in which their kinds come first.

    Args:
        parts: Arrays by name; those of a part have as many rows each.
        whole: Names of the arrays that are small and copied; rows of the others stay where they are.
    """
    kinds: dict[tuple[object, ...], list[Arrays]] = {}
    for part in parts:
        kind = tuple((name, array.shape[1:], str(array.dtype)) for name, array in sorted(part.items()))
        kinds.setdefault(kind, []).append(part)
    return [alike[0] if len(alike) == 1 else _joined(alike, whole) for alike in kinds.values()]


def _joined(parts: Sequence[Arrays], whole: Sequence[str]) -> Arrays:
    found: Arrays = {}
    for name in parts[0]:
        arrays = [part[name] for part in parts]
        # Whoever reads rows one by one sees no difference.
        found[name] = np.concatenate(arrays) if name in whole else cast(np.ndarray, JoinedRows(arrays))
    return found
