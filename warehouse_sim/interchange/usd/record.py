"""What USD has no schema for (ids, pockets, symmetries, names of textures): the custom data of prims."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from warehouse_sim.errors import DatasetError, shown
from warehouse_sim.interchange.usd.bindings import bindings

_REMEDY = "write the scene again with write_usd"


def keep(prim: Any, values: Mapping[str, Any]) -> None:
    """Add ``values`` to the custom data of a prim: numbers, texts, arrays of them; None is left out."""
    for key, value in values.items():
        if value is not None:
            prim.SetCustomDataByKey(key, _to_usd(value))


def _to_usd(value: Any) -> Any:
    vt = bindings().Vt
    if isinstance(value, np.ndarray):
        return vt.DoubleArray(np.asarray(value, float).ravel().tolist())
    if isinstance(value, (bool, str)):
        return value
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value)
    items = list(value)
    if all(isinstance(item, str) for item in items):
        return vt.StringArray(items)
    return vt.DoubleArray([float(item) for item in items])


class Record:
    """The custom data of one prim, read strictly.

    Args:
        path: File, for messages.
        prim: Whose custom data, as composed.
    """

    def __init__(self, path: Any, prim: Any) -> None:
        self._path, self._prim = path, prim
        self._values: dict[str, Any] = prim.GetCustomData()

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text; without a default it must be there."""
        value = self._value(key, default)
        if not isinstance(value, str):
            self.reject(key, value, "a text")
        return str(value)

    def texts(self, key: str) -> tuple[str, ...]:
        """Return texts, none where there are none."""
        value = self._values.get(key, ())
        if isinstance(value, str) or not isinstance(value, Sequence | bindings().Vt.StringArray):
            self.reject(key, value, "a list of texts")
        return tuple(str(item) for item in value)

    def whole(self, key: str, default: int | None = None) -> int:
        """Return a whole number."""
        value = self._value(key, default)
        if isinstance(value, bool) or not isinstance(value, int):
            self.reject(key, value, "a whole number")
        return int(value)

    def flag(self, key: str, default: bool = False) -> bool:
        """Return yes or no."""
        value = self._values.get(key, default)
        if not isinstance(value, (bool, int)):
            self.reject(key, value, "true or false")
        return bool(value)

    def number(self, key: str, default: float | None = None) -> float:
        """Return a finite number."""
        value = self._value(key, default)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value):
            self.reject(key, value, "a finite number")
        return float(value)

    def numbers(self, key: str, *shape: int) -> np.ndarray:
        """Return finite numbers in a shape; none at all where the first edge is -1 and the key is missing."""
        value = self._values.get(key, ())
        found = np.array(value, float) if not isinstance(value, str) else np.zeros(0)
        count = int(np.prod(shape[1:])) if shape[0] == -1 else int(np.prod(shape))
        fits = len(found) % count == 0 if shape[0] == -1 else len(found) == count
        if found.ndim != 1 or not fits or not np.isfinite(found).all():
            self.reject(key, value, f"finite numbers, {' x '.join(map(str, shape)).replace('-1', 'n')}")
        return found.reshape(shape)

    def reject(self, key: str, value: Any, wanted: str) -> None:
        """Raise the error for a value that cannot be used.

        Raises:
            DatasetError: Always.
        """
        raise DatasetError(
            f"{self._path}: {self._prim.GetPath()}: {key} must be {wanted}, found {shown(value)}; {_REMEDY}"
        )

    def _value(self, key: str, default: Any) -> Any:
        value = self._values.get(key, default)
        if value is None:
            raise DatasetError(f"{self._path}: {self._prim.GetPath()}: custom data lacks {key}; {_REMEDY}")
        return value
