"""Arrays, boxes and lenses as a user gives them; what they cannot be is an error that says so."""

from numbers import Real
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import InputError, shown
from warehouse_sim.geometry.fisheye import Fisheye, Lens, lens_of
from warehouse_sim.geometry.lens import Distortion


def given_numbers(value: Any, name: str) -> Float[np.ndarray, "..."]:
    """Return an array of numbers.

    Raises:
        InputError: It is none.
    """
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name} must be an array of numbers, found {shown(value)}") from None


def given_lens(value: Any) -> Lens | None:
    """Return a lens, or that of OpenCV's coefficients; None for None.

    Raises:
        InputError: It is none.
    """
    if value is None or isinstance(value, (Distortion, Fisheye)):
        return value
    coefficients = given_numbers(value, "distortion")
    if coefficients.ndim != 1 or len(coefficients) not in (4, 5):
        raise InputError(
            f"distortion must be k1, k2, p1, p2, k3 as in OpenCV, or k1 to k4 of a fisheye, found {shown(value)}"
        )
    try:
        return lens_of(coefficients.tolist())
    except ValueError as problem:
        raise InputError(f"distortion: {problem}") from problem


def is_number(value: Any) -> bool:
    """Return whether a value is a finite number; True is none."""
    return isinstance(value, Real) and not isinstance(value, bool) and bool(np.isfinite(float(value)))


def is_box(value: Any) -> bool:
    """Return whether a value is left, top, right and bottom."""
    try:
        box = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return False
    return box.shape == (4,) and bool(np.isfinite(box).all())
