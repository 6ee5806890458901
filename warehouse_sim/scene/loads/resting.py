"""Loads that rest by construction: level pieces lowered onto level tops, each with its weight over what carries it.

What is proved here needs no simulation: a piece that touches what is under it, whose centre of mass lies inside the
hull of the places where it does, stays (a rigid body on rigid supports; friction is not needed as nothing is inclined).
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.schema import ObjectModel

_LEVEL = 1e-7
"""Boxes whose axis is off the vertical by less (rad) are level."""
_TOUCH = 0.0002
"""Tops within this of the highest (m) carry, too: the air that a simulation's soft contact closes."""
_MOST_DROP, _MOST_SINK = 0.01, 0.001
"""A piece is lowered by at most the first and raised by at most the second (m)."""
_MARGIN = 0.01
"""The centre of mass lies at least this far inside the hull of the contact (m)."""
_EDGE = 1e-9
"""A point this near to an edge (m) is on it."""
_GRID = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 5)] * 2), axis=-1).reshape(-1, 2)
_WAYS = np.stack([np.cos(np.arange(16) * np.pi / 8), np.sin(np.arange(16) * np.pi / 8)])


def drop_to_rest(boxes: BoxStack, below: BoxStack, middle: Float[np.ndarray, " 2"] | None = None) -> float | None:
    """Return how far (m) a piece sinks until it rests on what is ``below``; None where that is not proved.

    Args:
        boxes: The collision boxes of the piece.
        below: Boxes that do not move.
        middle: x and y of its centre of mass (m), with what stands on it; that of evenly filled boxes by default.
    """
    if not is_level(boxes).all():
        return None
    bottoms = boxes.centre[:, 2] - boxes.half[:, 2]
    low = float(bottoms.min())
    tops = below.centre[:, 2] + below.half[:, 2]
    lows, highs = boxes.extents()
    under_low, under_high = below.extents()
    near = (under_low[:, :2] <= highs[:, :2].max(axis=0)).all(axis=1)
    near &= (under_high[:, :2] >= lows[:, :2].min(axis=0)).all(axis=1)
    near &= (under_high[:, 2] >= low - _MOST_DROP) & (under_low[:, 2] < low)
    carrying = below.subset(near)
    if not near.any() or not is_level(carrying).all():
        return None
    sole = boxes.subset(bottoms <= low + _TOUCH)
    # Points of either face: a grid on the piece alone misses what is narrow under it.
    above = _grid(carrying)
    points = np.concatenate([_grid(sole), above[_over(above, sole).any(axis=1)]])
    heights = _heights(points, carrying, tops[near], low + _MOST_SINK)
    top = float(heights.max())
    if not -_MOST_SINK <= low - top <= _MOST_DROP:
        return None
    if middle is None:
        volume = np.prod(boxes.half, axis=1)
        middle = volume @ boxes.centre[:, :2] / volume.sum()
    contact = points[heights >= top - _TOUCH]
    if not _holds(contact, middle):
        # The grids miss the corners of what the faces share: look for those before giving up.
        shared = _clamped(_grid(sole), carrying.subset((tops[near] >= top - _TOUCH) & (tops[near] <= top)))
        contact = np.concatenate([contact, shared[_over(shared, sole).any(axis=1)]])
    return low - top if _holds(contact, middle) else None


def _holds(contact: Float[np.ndarray, "n 2"], middle: Float[np.ndarray, " 2"]) -> bool:
    """Return whether ``middle`` (m) is inside the hull of the contact, with a margin."""
    return bool((((contact - middle) @ _WAYS).max(axis=0) >= _MARGIN).all())


def lowered_load(pieces: Sequence[tuple[ObjectModel, Transform]]) -> list[tuple[ObjectModel, Transform]]:
    """Return a unit load with its pallet on z = 0 and each piece on what carries it; others stay."""
    return [(model, T) for (model, _), T in zip(pieces, _lowered(pieces)[0], strict=True)]


def proved_load(pieces: Sequence[tuple[ObjectModel, Transform]]) -> list[Transform] | None:
    """Return the poses of a load's pieces, lowered onto each other and not onto z = 0; None where one may fall."""
    poses, proved = _lowered(pieces, on_floor=False)
    return poses if proved else None


def is_level(boxes: BoxStack) -> Bool[np.ndarray, " n"]:
    """Return of each box whether its own z axis is vertical."""
    return np.asarray(np.abs(boxes.rotation[:, 2, :2]).max(axis=1, initial=0.0) < _LEVEL)


def _lowered(pieces: Sequence[tuple[ObjectModel, Transform]], on_floor: bool = True) -> tuple[list[Transform], bool]:
    """Lower the pieces of a load, the lowest first; the first piece is the pallet."""
    stacks = [
        BoxStack.of([box.placed(T) for box in model.collision]) if model.collision else None for model, T in pieces
    ]
    poses, proved = [T for _, T in pieces], True
    done: list[BoxStack] = []
    solid = [
        (float((stack.centre[:, 2] - stack.half[:, 2]).min()), n) for n, stack in enumerate(stacks) if stack is not None
    ]
    for bottom, number in sorted(solid):
        stack = stacks[number]
        assert stack is not None
        drop: float | None = bottom if on_floor else 0.0
        if number:
            drop = drop_to_rest(stack, joined(done))
            proved &= drop is not None
        drop = drop or 0.0
        poses[number] = _lower(poses[number], drop)
        done.append(BoxStack(stack.centre - [0.0, 0.0, drop], stack.rotation, stack.half))
    return poses, proved


def _lower(T: Transform, drop: float) -> Transform:
    lowered = T.copy()
    lowered[2, 3] -= drop
    return lowered


def joined(stacks: Sequence[BoxStack]) -> BoxStack:
    """Return all boxes of ``stacks``, at least one, as one."""
    return BoxStack(
        np.concatenate([stack.centre for stack in stacks]),
        np.concatenate([stack.rotation for stack in stacks]),
        np.concatenate([stack.half for stack in stacks]),
    )


def _grid(boxes: BoxStack) -> Float[np.ndarray, "n 2"]:
    """Return a grid of points (m) on the horizontal faces of boxes, edges and corners among them."""
    offsets = _GRID[None] * boxes.half[:, None, :2]
    turned = np.einsum("bij,bpj->bpi", boxes.rotation[:, :2, :2], offsets)
    return np.asarray((boxes.centre[:, None, :2] + turned).reshape(-1, 2))


def _over(points: Float[np.ndarray, "n 2"], boxes: BoxStack) -> Bool[np.ndarray, "n m"]:
    """Return which points lie over or under which boxes."""
    away = points[:, None] - boxes.centre[None, :, :2]
    own = np.einsum("mji,nmj->nmi", boxes.rotation[:, :2, :2], away)
    return np.asarray((np.abs(own) <= boxes.half[None, :, :2] + _EDGE).all(axis=2))


def _clamped(points: Float[np.ndarray, "n 2"], boxes: BoxStack) -> Float[np.ndarray, "k 2"]:
    """Return for each of ``points`` (m) and each of ``boxes`` the nearest point of the box, seen from above."""
    turn = boxes.rotation[:, :2, :2]
    own = np.einsum("mji,nmj->nmi", turn, points[:, None] - boxes.centre[None, :, :2])
    own = np.clip(own, -boxes.half[None, :, :2], boxes.half[None, :, :2])
    return np.asarray((boxes.centre[None, :, :2] + np.einsum("mij,nmj->nmi", turn, own)).reshape(-1, 2))


def _heights(
    points: Float[np.ndarray, "n 2"], boxes: BoxStack, tops: Float[np.ndarray, " m"], limit: float
) -> Float[np.ndarray, " n"]:
    """Return the highest top (m) under each point that is not over ``limit``; minus infinity where there is none."""
    return np.asarray(np.where(_over(points, boxes) & (tops <= limit), tops, -np.inf).max(axis=1))
