"""Symmetry groups as BOP's models_info.json lists them: turns about an axis, continuous where they are fine enough."""

from typing import Any

import numpy as np

from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.symmetry import SymmetryGroup

FEWEST_TURNS = 36
"""Equal turns about one axis from which a shape counts as one of revolution: the surface of a prism of so many sides
leaves the cylinder by 0.4 % of its radius. The number is our own; BOP names none."""
_SAME = 1e-9


def symmetry_rows(group: SymmetryGroup) -> dict[str, Any]:
    """Return the entries ``symmetries_continuous`` and ``symmetries_discrete`` (mm), each only if there is one.

    A group of many equal turns about one of the axes x, y and z becomes that continuous axis and, where the shape can
    also be turned over, one discrete half-turn. All other groups are listed motion by motion, without the identity.
    """
    for axis in np.eye(3):
        fixed = _keeps(group, axis)
        if fixed.sum() < FEWEST_TURNS:
            continue
        turned_over = np.flatnonzero(~fixed)
        row: dict[str, Any] = {"symmetries_continuous": [{"axis": axis.tolist(), "offset": [0.0, 0.0, 0.0]}]}
        if len(turned_over) in (0, fixed.sum()):
            # What turns the axis over is one half-turn and then a turn about the axis.
            return row | _discrete(group, turned_over[:1])
    return _discrete(group, np.arange(1, len(group)))


def _keeps(group: SymmetryGroup, axis: np.ndarray) -> np.ndarray:
    """Return which motions leave every point of an axis through the origin where it is."""
    T = group.transforms
    return np.asarray(
        (np.abs(T[:, :3, :3] @ axis - axis).max(axis=1) < _SAME) & (np.abs(T[:, :3, 3]).max(axis=1) < _SAME)
    )


def _discrete(group: SymmetryGroup, rows: np.ndarray) -> dict[str, Any]:
    if len(rows) == 0:
        return {}
    T = group.transforms[rows]
    in_mm = make_transform(T[:, :3, :3], T[:, :3, 3] * 1000.0)
    return {"symmetries_discrete": (in_mm.reshape(-1, 16) + 0.0).tolist()}
