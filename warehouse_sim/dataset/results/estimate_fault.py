"""What is wrong with an estimate that somebody else's code made."""

from collections.abc import Iterable
from numbers import Integral, Real
from typing import Any

import numpy as np

from warehouse_sim.dataset.files.plain import is_rigid
from warehouse_sim.errors import InputError, shown
from warehouse_sim.schema import PoseEstimate

_TOLERANCE = 1e-2
"""How far rotations may be from orthonormal, as in files."""


def require_estimates(found: Any, where: str) -> list[PoseEstimate]:
    """Return estimates as a list.

    Args:
        found: What should be a list of estimates.
        where: Where it comes from, for messages.

    Raises:
        InputError: It is no list, or an estimate in it cannot be used.
    """
    if not isinstance(found, Iterable) or isinstance(found, (str, bytes, dict)):
        raise InputError(f"{where} must be a list of PoseEstimate, found {shown(found)}")
    estimates = list(found)
    for number, item in enumerate(estimates):
        problem = estimate_fault(item)
        if problem is not None:
            raise InputError(f"{where}: estimate {number}: {problem}")
    return estimates


def estimate_fault(item: Any) -> str | None:
    """Return what is wrong with an estimate; None if nothing is."""
    if not isinstance(item, PoseEstimate):
        return f"must be a PoseEstimate, found {shown(item)}"
    for name in ("scene_id", "image_id", "obj_id", "detection"):
        value = getattr(item, name)
        if not isinstance(value, Integral) or isinstance(value, bool):
            return f"{name} must be a whole number, found {shown(value)}"
    for name in ("score", "time"):
        value = getattr(item, name)
        if not isinstance(value, Real) or not np.isfinite(float(value)):
            return f"{name} must be a finite number, found {shown(value)}"
    for name in ("predicted_error", "error_bound"):
        value = getattr(item, name)
        if value is not None and (not isinstance(value, Real) or not float(value) >= 0):
            return f"{name} must be a distance (m) or None, found {shown(value)}"
    if not isinstance(item.name, str) or not isinstance(item.class_name, str):
        return f"name and class_name must be text, found {shown(item.name)} and {shown(item.class_name)}"
    covariance = item.covariance
    if covariance is not None and not (isinstance(covariance, np.ndarray) and covariance.shape == (6, 6)):
        return f"covariance must be a 6 x 6 array or None, found {shown(covariance)}"
    T = item.T_camera_object
    if not isinstance(T, np.ndarray) or T.shape != (4, 4) or T.dtype.kind not in "fiu":
        return f"T_camera_object must be a 4 x 4 array, found {shown(T)}"
    if not is_rigid(T.astype(float), _TOLERANCE):
        return f"T_camera_object must be a rotation and a translation (m), found {shown(T.tolist())}"
    return None
