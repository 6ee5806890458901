"""Between numpy and plain JSON data, with errors that name file and key."""

from typing import Any, TypeVar

import numpy as np

from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import Transform

T = TypeVar("T")


def plain(data: Any) -> Any:
    """Return ``data`` with arrays as nested lists and numpy scalars as Python numbers, without losing a digit."""
    if isinstance(data, dict):
        return {key: plain(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [plain(value) for value in data]
    if isinstance(data, np.ndarray):
        # Adding zero turns -0.0 into 0.0 and changes nothing else.
        return (data + 0.0 if data.dtype.kind == "f" else data).tolist()
    return data.item() if isinstance(data, np.generic) else data


def take(data: Any, key: str, kind: type[T], where: str) -> T:
    """Return ``data[key]``, which must be of type ``kind``; a whole number passes for a float.

    Raises:
        DatasetError: No such key, or a value of another type.
    """
    if not isinstance(data, dict) or key not in data:
        raise DatasetError(f"{where}: the entry {key!r} is missing")
    value = data[key]
    if kind is float and type(value) is int:
        return float(value)  # type: ignore[return-value]
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise DatasetError(f"{where}: {key} must be of type {kind.__name__}, found {value!r}")
    return value


def read_transform(data: Any, where: str) -> Transform:
    """Read a 4x4 rigid transform.

    Raises:
        DatasetError: Not sixteen finite numbers, or no rigid transform.
    """
    try:
        T_a_b = np.array(data, dtype=float)
    except (TypeError, ValueError) as problem:
        raise DatasetError(f"{where}: a 4x4 matrix of numbers is expected ({problem})") from problem
    if T_a_b.shape != (4, 4) or not is_rigid(T_a_b):
        raise DatasetError(f"{where}: is not a rigid 4x4 transform: {T_a_b.tolist()}")
    return T_a_b


def is_rigid(T_a_b: Transform, tolerance: float = 1e-6) -> bool:
    """Say whether a 4x4 matrix is finite, orthonormal to ``tolerance``, with determinant +1 and last row 0 0 0 1."""
    R = T_a_b[:3, :3]
    return bool(
        np.isfinite(T_a_b).all()
        and np.abs(R @ R.T - np.eye(3)).max() <= tolerance
        and np.linalg.det(R) > 0
        and np.array_equal(T_a_b[3], [0, 0, 0, 1])
    )
