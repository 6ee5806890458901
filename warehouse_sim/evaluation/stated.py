"""Numbers as scores.json states them: six decimals, and null for what is not finite, such as a median among misses."""

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np

from warehouse_sim.dataset.files.plain import NUMBERS, take_if_given


def _stated(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _stated(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [_stated(item) for item in value]
    # Six decimals: below what any of these numbers means, above what summation order changes.
    return round(float(value), 6) if np.isfinite(value) else None


class _Number:
    @staticmethod
    def from_plain(value: Any, where: str) -> float:
        place, _, key = where.rpartition(": ")
        found = take_if_given({key: value}, key, float, place, NUMBERS)
        return float("nan") if found is None else found


Number = Annotated[float, _Number()]
"""Read back, null is nan."""
STATED = {"to_plain": _stated}
"""Metadata of a field of numbers, alone or in tuples and mappings."""
