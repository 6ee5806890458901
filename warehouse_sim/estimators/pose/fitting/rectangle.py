"""Where a box of known size stands upright, from the points of the sides that are seen: no network, nothing learnt.

Seen from above the points lie on one or two sides of a rectangle. Its direction is the one in which they are nearest to
the sides of their bounding rectangle (the closeness of Zhang et al., "Efficient L-shape fitting for vehicle detection
using laser scanners", IV 2017); its near corner stays, its size is that of the object.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform, Transforms, make_transform, rotation_z

_DIRECTIONS = 45
"""Directions that are tried in a quarter turn."""
_OUTER = (0.02, 0.98)
"""Quantiles that stand for the border of a set of points: some readings lie between two surfaces."""
_WHOLE = 0.8
"""Share of the height from which all of it counts as seen."""
_LEAST_DISTANCE = 0.01
"""Nearer to a side (m) than this, all points count the same."""


@dataclass(frozen=True, eq=False)
class _Rectangle:
    """A rectangle about points seen from above, in the upright frame."""

    yaw: float
    """Direction of its first side (rad)."""
    low: Float[np.ndarray, " 2"]
    """Least coordinates along its sides (m)."""
    high: Float[np.ndarray, " 2"]
    """Greatest ones."""


def upright_boxes(points: Float[np.ndarray, "n 3"], size: Float[np.ndarray, " 3"]) -> Transforms:
    """Return the upright poses ``T_upright_object`` of a box that go with points of its surface, "h 4 4".

    The sides that face the sensor, which is at the origin, touch the points; which of the box's sides is which, nobody
    knows yet: the poses are quarter turns apart. Where less than most of its height is seen, the points may be its
    lower or its upper part, and there are poses for both.

    Args:
        points: In a frame with z up and the sensor at its origin (m).
        size: Edge lengths of the box (m).
    """
    found = _fit_rectangle(points[:, :2])
    low, high = np.quantile(points[:, 2], _OUTER)
    # What stands on the object hides its top, the image's border its foot.
    whole = high - low >= _WHOLE * size[2]
    heights = [(low + high) / 2.0] if whole else [low + size[2] / 2.0, high - size[2] / 2.0]
    return np.stack([_placed(found, size, height, quarter) for height in heights for quarter in range(4)])


def _fit_rectangle(points: Float[np.ndarray, "n 2"]) -> _Rectangle:
    step = np.pi / 2.0 / _DIRECTIONS
    coarse = np.arange(_DIRECTIONS) * step
    finer = coarse[_closeness(points, coarse).argmax()] + np.linspace(-step, step, 9)
    yaw = float(finer[_closeness(points, finer).argmax()])
    low, high = np.quantile(points @ _axes(yaw), _OUTER, axis=0)
    return _Rectangle(yaw, low, high)


def _closeness(points: Float[np.ndarray, "n 2"], yaws: Float[np.ndarray, " d"]) -> Float[np.ndarray, " d"]:
    """Return how near to the sides of their rectangle the points lie, for each of some directions."""
    along = np.stack([(points @ _axes(float(yaw))).T for yaw in yaws])
    low, high = np.quantile(along, _OUTER, axis=2)[..., None]
    inside = np.minimum(np.abs(along - low), np.abs(high - along)).min(axis=1)
    return (1.0 / np.maximum(inside, _LEAST_DISTANCE)).sum(axis=1)


def _placed(found: _Rectangle, size: Float[np.ndarray, " 3"], centre_z: float, quarter: int) -> Transform:
    """Return the pose whose x axis is ``quarter`` quarter turns from the rectangle's first side."""
    length, width = size[[0, 1]] if quarter % 2 == 0 else size[[1, 0]]
    sides = np.array([length, width])
    middle = (found.low + found.high) / 2.0
    seen = found.high - found.low
    # The near sides, those on the sensor's side of the middle, are where the points begin; the far ones follow from the
    # size. Along a side that is seen from end to end the middle is surer than either end.
    near = np.where(middle > 0.0, found.low, found.high)
    centre = near + np.sign(middle) * sides / 2.0
    centre = np.where(np.abs(seen - sides) <= 0.15 * sides, middle, centre)
    place = _axes(found.yaw) @ centre
    return make_transform(rotation_z(found.yaw + quarter * np.pi / 2.0), np.array([*place, centre_z]))


def _axes(yaw: float) -> Float[np.ndarray, "2 2"]:
    """Return the directions of a rectangle's sides as columns."""
    return np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
