"""What USD has no schema for (ids, pockets, symmetries, names of textures): the custom data of prims."""

from collections.abc import Mapping
from typing import Any, NoReturn

import numpy as np

from warehouse_sim.config import convert
from warehouse_sim.errors import ConfigError, DatasetError, shown
from warehouse_sim.interchange.usd.bindings import bindings

_REMEDY = "write the scene again with write_usd"
_REQUIRED = object()


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

    def get(self, key: str, hint: Any, default: Any = _REQUIRED) -> Any:
        """Return a value of a type, ``tuple[str, ...]`` of texts, numbers finite; without a default it must be there.

        Raises:
            DatasetError: It is missing, or of another type.
        """
        value = self._values.get(key, default)
        if value is _REQUIRED:
            raise DatasetError(f"{self._path}: {self._prim.GetPath()}: custom data lacks {key}; {_REMEDY}")
        if key not in self._values:
            return default
        try:
            found = convert(hint, list(value) if isinstance(value, bindings().Vt.StringArray) else value, key)
        except ConfigError:
            self.reject(key, value, f"of type {getattr(hint, '__name__', hint)}")
        if hint is float and not np.isfinite(found):
            self.reject(key, value, "a finite number")
        return found

    def numbers(self, key: str, *shape: int) -> np.ndarray:
        """Return finite numbers in a shape; none at all where the first edge is -1 and the key is missing."""
        value = self._values.get(key, ())
        found = np.array(value, float) if not isinstance(value, str) else np.zeros(0)
        count = int(np.prod(shape[1:])) if shape[0] == -1 else int(np.prod(shape))
        fits = len(found) % count == 0 if shape[0] == -1 else len(found) == count
        if found.ndim != 1 or not fits or not np.isfinite(found).all():
            self.reject(key, value, f"finite numbers, {' x '.join(map(str, shape)).replace('-1', 'n')}")
        return found.reshape(shape)

    def reject(self, key: str, value: Any, wanted: str) -> NoReturn:
        """Raise the error for a value that cannot be used.

        Raises:
            DatasetError: Always.
        """
        raise DatasetError(
            f"{self._path}: {self._prim.GetPath()}: {key} must be {wanted}, found {shown(value)}; {_REMEDY}"
        )
