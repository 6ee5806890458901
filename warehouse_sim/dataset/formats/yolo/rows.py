"""Rows of YOLO's label files: class number, then fractions of the image's width and height, each 0 to 1."""

from collections.abc import Iterable, Sequence

import numpy as np
from jaxtyping import Float

_DIGITS = 7


def box_row(number: int, box_xyxy: tuple[float, float, float, float], size_wh: tuple[int, int]) -> str:
    """Return class, centre and size of a box of inclusive pixel corners."""
    left, top, right, bottom = box_xyxy
    edges = np.array([[left, top], [right + 1, bottom + 1]]) / size_wh
    return _row(number, np.concatenate([edges.mean(axis=0), edges[1] - edges[0]]))


def corner_row(number: int, corners: Float[np.ndarray, "n 2"], size_wh: tuple[int, int]) -> str:
    """Return class and corners of a polygon or an oriented box, given in pixels from the image's outer corner."""
    return _row(number, (corners / size_wh).ravel())


def point_row(
    number: int,
    box_xyxy: tuple[float, float, float, float],
    points: Float[np.ndarray, "n 3"],
    size_wh: tuple[int, int],
) -> str:
    """Return class, box and key points with their flags; ``points`` have pixel centres at integers."""
    parts = [box_row(number, box_xyxy, size_wh)]
    for u, v, flag in points:
        fractions = np.clip((np.array([u, v]) + 0.5) / size_wh, 0.0, 1.0) if flag else np.zeros(2)
        parts.append(f"{_numbers(fractions)} {int(flag)}")
    return " ".join(parts)


def label_file(rows: Iterable[str]) -> bytes:
    """Return the file of all rows; equal ones are written once, since tools take the second one for an error."""
    return "".join(f"{row}\n" for row in dict.fromkeys(rows)).encode("ascii")


def _row(number: int, fractions: Sequence[float] | np.ndarray) -> str:
    return f"{number} {_numbers(np.clip(fractions, 0.0, 1.0))}"


def _numbers(fractions: Sequence[float] | np.ndarray) -> str:
    return " ".join(f"{fraction:.{_DIGITS}f}".rstrip("0").rstrip(".") for fraction in fractions)
