"""Objects of one image decided together: two of them do not explain the same points.

A detection may be of several objects that touch, or two detections of one mask. Each pose claims the points that lie on
its surface; poses that share claims are looked for once more among the points that the others leave, and the set of
poses is taken whose verification, less a price for what is claimed twice, is best.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.estimators.pose.fitting.hypotheses import LEAST_POINTS
from warehouse_sim.estimators.pose.fitting.search import VERIFICATION, FitConfig, Found, Sought, search
from warehouse_sim.estimators.pose.fitting.verification import TOLERANCE_FRACTION, DepthView
from warehouse_sim.estimators.pose.icp.nearest import NearestByCell
from warehouse_sim.geometry.pose import Transforms, invert, transform_points

_NOBODY_PROPOSES = np.empty((0, 4, 4))
_POINTS = 200
"""Points of each detection that are claimed."""
_CLAIMED = 0.3
"""Fraction of its claims that a pose may have in common with another: neighbours touch."""
_PRICE = 2.0
"""Of a fraction of claims beyond that, in units of the verification."""
_EXPLAINED = 0.5
"""What a set is worth that explains all points of one detection, in units of the verification."""


def search_jointly(sought: Sequence[Sought], config: FitConfig) -> list[Found]:
    """Return what is found of each object, where those of one image do not explain the same points.

    Of the objects that one detection may be, that with the most verification takes part; the others stay as they are
    found.
    """
    found = search(sought, config)
    images: dict[int, list[int]] = {}
    for i in _leading(sought, found):
        # Detections of one image share its array.
        images.setdefault(id(sought[i].view.depth), []).append(i)
    for members in images.values():
        shared = _shared_out([sought[i] for i in members], [found[i] for i in members], config)
        found = [shared[members.index(i)] if i in members else item for i, item in enumerate(found)]
    return found


def _leading(sought: Sequence[Sought], found: Sequence[Found]) -> list[int]:
    best: dict[int, int] = {}
    for i, item in enumerate(sought):
        other = best.setdefault(item.detection, i)
        if found[i].verification[0].score > found[other].verification[0].score:
            best[item.detection] = i
    return list(best.values())


def _shared_out(sought: Sequence[Sought], found: Sequence[Found], config: FitConfig) -> list[Found]:
    """Return the poses of the objects of one image, the chosen ones first."""
    if len(sought) < 2:
        return list(found)
    points = np.concatenate([item.points[:_POINTS] for item in sought])
    claims = [_claims(item, one.T_camera_object, points) for item, one in zip(sought, found, strict=True)]
    first = _common(np.stack([one[0] for one in claims]).astype(float))
    np.fill_diagonal(first, 0.0)
    contested = np.flatnonzero((first > _CLAIMED).any(axis=1))
    if len(contested) == 0:
        return list(found)
    found, claims = list(found), list(claims)
    for i, more in _among_the_rest(sought, found, contested, first, config).items():
        found[i] = found[i].with_others(more)
        claims[i] = _claims(sought[i], found[i].T_camera_object, points)
    chosen = _best_set([np.array([item.score for item in one.verification]) for one in found], claims)
    return [one.led_by(number) for one, number in zip(found, chosen, strict=True)]


def _among_the_rest(
    sought: Sequence[Sought],
    found: Sequence[Found],
    contested: Int[np.ndarray, " c"],
    common: Float[np.ndarray, "n n"],
    config: FitConfig,
) -> dict[int, Found]:
    """Return what else the contested objects may be, where those that contest them are not, by their numbers."""
    left = dict[int, Sought]()
    for i in map(int, contested):
        # What a network trusts is of one object; of what the others leave it may have trusted nothing.
        view = sought[i].whole
        for j in map(int, np.flatnonzero(common[i] > _CLAIMED)):
            view = _without(view, sought[j], found[j].T_camera_object[:1])
        if len(view.points) >= LEAST_POINTS:
            left[i] = Sought.of(sought[i].model, view, _NOBODY_PROPOSES, i)
    return dict(zip(left, search(list(left.values()), config), strict=True)) if left else {}


def _without(view: DepthView, other: Sought, T_camera_object: Transforms) -> DepthView:
    """Return a view whose mask claims nothing that lies on the surface of another object."""
    v, u = np.nonzero(view.mask & (view.depth > 0))
    points = view.camera.rays_at(u, v) * view.depth[v, u][:, None].astype(float)
    near = np.linalg.norm(points - T_camera_object[0, :3, 3], axis=1) <= other.model.extent
    v, u, points = v[near], u[near], points[near]
    mask, taken = view.mask.copy(), _claims(other, T_camera_object, points)[0]
    mask[v[taken], u[taken]] = False
    free = ~_claims(other, T_camera_object, view.points)[0]
    return replace(view, mask=mask, points=view.points[free])


def _claims(item: Sought, T_camera_object: Transforms, points: Float[np.ndarray, "p 3"]) -> Bool[np.ndarray, "h p"]:
    """Return which points lie on the surface of an object in each of some poses."""
    T_object_camera = invert(T_camera_object)
    seen = NearestByCell([item.model.cells] * len(T_camera_object), T_object_camera[:, :3, 3])
    placed = transform_points(T_object_camera, np.broadcast_to(points, (len(T_camera_object), *points.shape)))
    distance, _ = seen.nearest(placed)
    on: Bool[np.ndarray, "h p"] = np.abs(distance) <= VERIFICATION.tolerance + TOLERANCE_FRACTION * points[:, 2]
    return on


def _common(claims: Float[np.ndarray, "n p"]) -> Float[np.ndarray, "n n"]:
    """Return which fraction of the claims of the smaller of two poses both have."""
    count = claims.sum(axis=1)
    return claims @ claims.T / np.maximum(np.minimum(count[:, None], count), 1.0)


def _best_set(scores: Sequence[Float[np.ndarray, " h"]], claims: Sequence[Bool[np.ndarray, "h p"]]) -> list[int]:
    """Return which pose of each object is taken, so that the set is worth most.

    A set is worth its verification and the points that it explains, each once, less the price of shared claims. It is
    improved object by object, from the best pose of each, and from each other pose in its place.
    """
    owner = np.repeat(np.arange(len(scores)), [len(one) for one in scores])
    each = np.concatenate(claims).astype(float)
    both, common = each @ each.T, _common(each)
    cost = _PRICE * np.maximum(common - _CLAIMED, 0.0) + _EXPLAINED / _POINTS * both
    cost[owner[:, None] == owner] = 0.0
    value = np.concatenate(scores) + _EXPLAINED / _POINTS * each.sum(axis=1)
    rows = [np.flatnonzero(owner == i) for i in range(len(scores))]
    best = _improved([int(row[0]) for row in rows], rows, value, cost)
    for pose in np.flatnonzero((common * (owner[:, None] != owner) > _CLAIMED).any(axis=1)):
        start = [int(pose) if i == owner[pose] else int(row[0]) for i, row in enumerate(rows)]
        other = _improved(start, rows, value, cost, last=int(owner[pose]))
        if _worth(other, value, cost) > _worth(best, value, cost) + 1e-9:
            best = other
    return [int(pose - row[0]) for pose, row in zip(best, rows, strict=True)]


def _improved(
    chosen: list[int],
    rows: Sequence[Int[np.ndarray, " h"]],
    value: Float[np.ndarray, " n"],
    cost: Float[np.ndarray, "n n"],
    last: int = 0,
) -> list[int]:
    """Return a set of poses that no other pose of one object makes better; object ``last`` changes last."""
    chosen, spent = list(chosen), cost[:, chosen].sum(axis=1)
    order = [*range(last + 1, len(rows)), *range(last + 1)]
    for _ in range(len(rows) + 1):
        before = list(chosen)
        for i in order:
            worth = value[rows[i]] - spent[rows[i]]
            if worth.max() > worth[chosen[i] - rows[i][0]] + 1e-9:
                taken = int(rows[i][worth.argmax()])
                spent += cost[:, taken] - cost[:, chosen[i]]
                chosen[i] = taken
        if chosen == before:
            break
    return chosen


def _worth(chosen: Sequence[int], value: Float[np.ndarray, " n"], cost: Float[np.ndarray, "n n"]) -> float:
    return float(value[chosen].sum() - cost[np.ix_(chosen, chosen)].sum() / 2.0)
