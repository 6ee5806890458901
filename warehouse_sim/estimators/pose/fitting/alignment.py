"""Objects of one image that stand parallel: far and covered ones do not show their heading, but their neighbours do.

Pallets stand along or across each other in racks, lanes and stacks. The headings of the others of an image, quarter
turns left out, say how each is expected to stand. Its best poses are fitted so, too, and agreement with the others
counts as verification. It decides where readings do not; what plainly stands askew stays askew.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.gravity import upright_frame
from warehouse_sim.estimators.pose.fitting.search import (
    FINE,
    VERIFICATION,
    FitConfig,
    Found,
    Sought,
    fit_finely,
    lead_of,
)
from warehouse_sim.estimators.pose.fitting.verification import judge_all
from warehouse_sim.geometry.pose import Transforms, make_transform, rotation_z

_LEAST_OBJECTS = 3
_QUARTER = np.pi / 2.0
_SPREAD = 0.045
"""Standard deviation of the headings of what stands parallel (rad)."""
_ENOUGH = 500.0
"""Points of an object whose heading counts half."""
_ASKEW = 0.5
"""Weight of headings that are like nobody's, beside the neighbours'."""
_LEAST_PART = 0.25
"""Part of the weight that must agree on a heading before it is tried."""
_WORTH = 0.2
"""Of a heading that all others have, in units of the verification."""
_EITHER_QUARTER = 0.45
"""A heading that is off by more than this (rad) may belong to the next quarter turn as well."""
_POSES = 2
"""Of each object, the best ones, that are turned."""
_PRIOR_TURN = 0.02
"""Of the ICP of what is turned (rad): it hardly turns it back."""


def in_line(sought: Sequence[Sought], found: Sequence[Found], config: FitConfig) -> list[Found]:
    """Return what is found of the objects of one image, that pose first for which image and neighbours speak.

    Where no ICP follows, poses stay as they are: baselines look at one object alone.
    """
    if not config.refine or len(sought) < _LEAST_OBJECTS:
        return list(found)
    headings = np.array([_headings(item, one.T_camera_object[:1])[0] for item, one in zip(sought, found, strict=True)])
    counts = np.array([len(item.points) for item in sought])
    weights = ~np.eye(len(sought), dtype=bool) * counts / (counts + _ENOUGH)
    turned = [
        _turned(item, one.T_camera_object[:_POSES], *expected_heading(headings, weight))
        for item, one, weight in zip(sought, found, weights, strict=True)
    ]
    if not any(map(len, turned)):
        return list(found)
    fitted = fit_finely(sought, turned, FINE._replace(grazing=config.grazing, prior_turn=_PRIOR_TURN))
    return [
        _chosen(item, one, poses, headings, weight)
        for item, one, poses, weight in zip(sought, found, fitted, weights, strict=True)
    ]


def agreeing(
    headings: Float[np.ndarray, " n"], others: Float[np.ndarray, " m"], weight: Float[np.ndarray, " m"]
) -> Float[np.ndarray, " n"]:
    """Return which part of the weight of other headings (rad) agrees with each heading, 0-1, quarter turns left out."""
    near = np.exp(-0.5 * (_off(headings[:, None] - others) / _SPREAD) ** 2)
    return near @ weight / (weight.sum() + _ASKEW)


def expected_heading(headings: Float[np.ndarray, " m"], weight: Float[np.ndarray, " m"]) -> tuple[float, float]:
    """Return the heading (rad) on which most of the weight agrees, and which part that is."""
    part = agreeing(headings, headings, weight)
    best = headings[part.argmax()]
    off = _off(headings - best)
    near = weight * np.exp(-0.5 * (off / _SPREAD) ** 2)
    return float(best + near @ off / max(near.sum(), 1e-9)), float(part.max())


def _off(angles: Float[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
    """Return angles less the quarter turn next to each."""
    return angles - _QUARTER * np.rint(angles / _QUARTER)


def _frame(item: Sought) -> Float[np.ndarray, "3 3"]:
    return upright_frame(np.array([0.0, 1.0, 0.0]) if item.view.down is None else item.view.down)


def _headings(item: Sought, T_camera_object: Transforms) -> Float[np.ndarray, " h"]:
    """Return the angles of an object's x axis about the vertical (rad) in some poses."""
    along = T_camera_object[:, :3, 0] @ _frame(item)
    return np.arctan2(along[:, 1], along[:, 0])


def _turned(item: Sought, T_camera_object: Transforms, heading: float, part: float) -> Transforms:
    """Return poses turned about the middle of the object's points to the expected heading, each its nearest way first.

    None are returned where too little agrees on it.
    """
    if part < _LEAST_PART:
        return np.empty((0, 4, 4))
    middle, R_camera_upright, poses = np.median(item.points, axis=0), _frame(item), []
    for T, off in zip(T_camera_object, _off(heading - _headings(item, T_camera_object)), strict=True):
        for turn in (off, off - np.sign(off) * _QUARTER)[: 1 + (abs(off) > _EITHER_QUARTER)]:
            R = R_camera_upright @ rotation_z(turn) @ R_camera_upright.T
            poses.append(make_transform(R @ T[:3, :3], R @ (T[:3, 3] - middle) + middle))
    return np.stack(poses)


def _chosen(
    item: Sought,
    found: Found,
    turned: Transforms,
    headings: Float[np.ndarray, " m"],
    weight: Float[np.ndarray, " m"],
) -> Found:
    """Return the poses of an object with the turned ones among them, the best first.

    What was first leads as a network's pose does, and so does the same pose turned.
    """
    count = len(found.verification)
    leads = np.isin(np.arange(count + len(turned)), [0, count])
    lead = leads * lead_of(item, found.verification[0])
    if len(turned):
        verification = judge_all(turned, item.model.surface, item.view, VERIFICATION)
        found = found.with_others(Found(turned, tuple(verification)))
    worth = lead + [one.score for one in found.verification]
    worth += _WORTH * agreeing(_headings(item, found.T_camera_object), headings, weight)
    return found.led_by(int(worth.argmax()))
