"""Objects of one image decided one after the other: two of them do not explain the same points.

A detection may be of several objects that touch, or two detections of one object. Each pose claims the points that lie
on its surface. The pose with the most verification stands; one that shares claims with those that stand is looked for
once more among the points that they leave, and of all its poses that is taken whose verification, with the points that
it alone explains and less a price for what is claimed twice, is best.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.pose.fitting.alignment import in_line
from warehouse_sim.estimators.pose.fitting.hypotheses import LEAST_POINTS
from warehouse_sim.estimators.pose.fitting.search import VERIFICATION, FitConfig, Found, Sought, search, worth
from warehouse_sim.estimators.pose.fitting.verification import TOLERANCE_FRACTION, DepthView
from warehouse_sim.estimators.pose.icp.nearest import NearestByCell
from warehouse_sim.geometry.pose import Transforms, invert, transform_points

_NOBODY_PROPOSES = np.empty((0, 4, 4))
_POINTS = 200
"""Points of each detection that are claimed."""
_CLAIMED = 0.3
"""Fraction of its claims that a pose may have in common with another: neighbours touch."""
_PRICE = 0.5
"""Of a fraction of claims beyond that, in units of the verification."""
_EXPLAINED = 0.5
"""What it is worth to explain all points of one detection, in units of the verification."""


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
        those = [sought[i] for i in members]
        shared = _shared_out(those, in_line(those, [found[i] for i in members], config), config)
        found = [shared[members.index(i)] if i in members else item for i, item in enumerate(found)]
    return found


def _leading(sought: Sequence[Sought], found: Sequence[Found]) -> list[int]:
    best: dict[int, int] = {}
    for i, item in enumerate(sought):
        other = best.setdefault(item.detection, i)
        if worth(item, found[i]) > worth(sought[other], found[other]):
            best[item.detection] = i
    return list(best.values())


def _shared_out(sought: Sequence[Sought], found: Sequence[Found], config: FitConfig) -> list[Found]:
    """Return the poses of the objects of one image, the chosen ones first."""
    if len(sought) < 2:
        return list(found)
    points = np.concatenate([item.points[:_POINTS] for item in sought])
    claims = [_claims(item, one.T_camera_object, points) for item, one in zip(sought, found, strict=True)]
    order = sorted(range(len(found)), key=lambda i: -found[i].verification[0].score)
    rank = np.argsort(order)
    rivals = (rank[:, None] > rank) & (_common(np.stack([one[0] for one in claims])) > _CLAIMED)
    found, chosen = list(found), list[Bool[np.ndarray, " p"]]()
    for i, more in _among_the_rest(sought, found, rivals, config).items():
        found[i] = found[i].with_others(more)
        claims[i] = np.concatenate([claims[i], _claims(sought[i], more.T_camera_object, points)])
    for i in order:
        number = _best(found[i], claims[i], np.stack(chosen)) if rivals[i].any() else 0
        found[i] = found[i].led_by(number)
        chosen.append(claims[i][number])
    return found


def _among_the_rest(
    sought: Sequence[Sought], found: Sequence[Found], rivals: Bool[np.ndarray, "n n"], config: FitConfig
) -> dict[int, Found]:
    """Return what else objects may be, where the surer ones, ``rivals`` in their rows, are not."""
    left = dict[int, Sought]()
    for i in map(int, np.flatnonzero(rivals.any(axis=1))):
        # What a network trusts is of one object; of what the others leave it may have trusted nothing.
        view = sought[i].whole
        for j in map(int, np.flatnonzero(rivals[i])):
            view = _without(view, sought[j], found[j].T_camera_object[:1])
        if len(view.points) >= LEAST_POINTS:
            left[i] = Sought.of(sought[i].model, view, _NOBODY_PROPOSES, i)
    return dict(zip(left, search(list(left.values()), config), strict=True)) if left else {}


def _best(found: Found, claims: Bool[np.ndarray, "h p"], taken: Bool[np.ndarray, "k p"]) -> int:
    """Return the number of the pose that is worth most beside the claims that are taken."""
    own = claims.astype(float)
    both = own @ taken.T.astype(float)
    common = both / np.maximum(np.minimum(own.sum(axis=1)[:, None], taken.sum(axis=1)), 1.0)
    worth = np.array([one.score for one in found.verification])
    worth -= _PRICE * np.maximum(common - _CLAIMED, 0.0).sum(axis=1)
    worth += _EXPLAINED / _POINTS * (own.sum(axis=1) - both.sum(axis=1))
    return int(worth.argmax())


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


def _common(claims: Bool[np.ndarray, "n p"]) -> Float[np.ndarray, "n n"]:
    """Return which fraction of the claims of the smaller of two poses both have."""
    each, count = claims.astype(float), claims.sum(axis=1)
    return each @ each.T / np.maximum(np.minimum(count[:, None], count), 1.0)
