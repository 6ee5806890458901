"""Look at the estimates of whatever estimator, in the images that it was given, and say if openings are free.

Rays that pass an opening of the CAD surface run on for a while inside the object's box. Where a reading ends such a ray
early, something stands in the opening that is not the object's.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators.api import PoseEstimator, WrappedEstimator
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.matching import observed
from warehouse_sim.estimators.pose.icp.surface import CadSurface, seeded_surface
from warehouse_sim.estimators.pose.uncertainty.covariance import rms_quantile
from warehouse_sim.estimators.pose.uncertainty.features import Look, look
from warehouse_sim.estimators.pose.uncertainty.model import UncertaintyModel
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.schema import Observation, PoseEstimate

_RAYS = 600
"""Readings that are looked at, of all in the outline of the object's box."""
_DEEP = 0.2
"""So long (m) a ray runs on inside the box where it has entered an opening."""
_BEFORE = 0.5
"""What stands so near before an opening (m) blocks it, too."""
_MARGIN, _NOISE = 0.06, 0.004
"""A ray ends early where it is shorter by this (m), and by this fraction of the squared range (1/m): three deviations
of the depth cameras of docs/sensors.md stay below it to 5 m."""
_LEAST_RAYS = 8
"""With fewer an opening was not seen."""
_LEAST_FRACTION = 0.4
"""Of the rays of an opening that end early where it is blocked."""
_BLOCK = 200_000
"""Pairs of ray and triangle at once."""


class Openings(NamedTuple):
    """What is seen of an object's openings, on the left and on the right of its middle."""

    rays: tuple[int, int]
    """That enter an opening."""
    ended: tuple[int, int]
    """Those of them that end early."""

    @property
    def blocked(self) -> bool:
        """Whether one of them is blocked, of those that are seen."""
        pairs = zip(self.rays, self.ended, strict=True)
        return any(rays >= _LEAST_RAYS and ended >= _LEAST_FRACTION * rays for rays, ended in pairs)


def look_into(T_camera_object: Transform, mesh: TriangleMesh, image: RgbdImage, rng: np.random.Generator) -> Openings:
    """Return what is seen of an object's openings.

    Args:
        T_camera_object: Where the object is thought to be.
        mesh: Its CAD surface (m, object frame).
        image: Where it was seen.
        rng: Decides which readings are looked at.
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    points = _readings_about(T_camera_object, low, high, image, rng)
    T_object_camera = invert(T_camera_object)
    start = T_object_camera[:3, 3]
    ends = transform_points(T_object_camera, points)
    reach = np.linalg.norm(ends - start, axis=1)
    along = (ends - start) / reach[:, None]
    enters, leaves = _through_box(start, along, low, high)
    inside = leaves > enters
    along, reach, enters, leaves = along[inside], reach[inside], enters[inside], leaves[inside]
    first = np.minimum(_first_hits(start, along, mesh), leaves)
    margin = _MARGIN + _NOISE * reach**2
    deep = first - enters > np.maximum(_DEEP, 1.5 * margin)
    early = (reach < first - margin) & (reach > enters - _BEFORE)
    # What hides the object from farther away says nothing of its openings.
    seen = deep & (reach > enters - _BEFORE)
    place = start + along * enters[:, None]
    side = _side_of(place, start, low, high)
    rays = tuple(int((seen & (side == number)).sum()) for number in (0, 1))
    ended = tuple(int((seen & early & (side == number)).sum()) for number in (0, 1))
    return Openings((rays[0], rays[1]), (ended[0], ended[1]))


def _readings_about(
    T_camera_object: Transform, low: np.ndarray, high: np.ndarray, image: RgbdImage, rng: np.random.Generator
) -> Float[np.ndarray, "n 3"]:
    """Return readings (m, camera frame) in the window of the object's box, at most ``_RAYS``."""
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    seen = transform_points(T_camera_object, corners)
    seen[:, 2] = np.maximum(seen[:, 2], 0.1)
    pixels = image.camera.project(seen)
    height, width = image.depth.shape
    left, top = np.clip(np.floor(pixels.min(axis=0)).astype(int), 0, [width, height])
    right, bottom = np.clip(np.ceil(pixels.max(axis=0)).astype(int) + 1, 0, [width, height])
    rows, columns = np.nonzero(image.depth[top:bottom, left:right] > 0)
    chosen = rng.permutation(len(rows))[:_RAYS]
    v, u = rows[chosen] + top, columns[chosen] + left
    found: Float[np.ndarray, "n 3"] = image.camera.rays_at(u, v) * image.depth[v, u, None]
    return found


def _through_box(
    start: np.ndarray, along: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Return where rays enter and leave a box (m along them); they miss it where they leave before they enter."""
    safe = np.where(np.abs(along) < 1e-9, 1e-9, along)
    one, other = (low - start) / safe, (high - start) / safe
    return np.minimum(one, other).max(axis=1).clip(min=0.0), np.maximum(one, other).min(axis=1)


def _first_hits(start: np.ndarray, along: np.ndarray, mesh: TriangleMesh) -> Float[np.ndarray, " n"]:
    """Return how far rays run to a surface (m), infinity where they miss it.

    Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
    """
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    edge_b, edge_c, offset = b - a, c - a, start - a
    across = np.cross(offset, edge_b)
    height = (across * edge_c).sum(axis=1)
    found = np.full(len(along), np.inf)
    step = max(1, _BLOCK // max(len(a), 1))
    for first in range(0, len(along), step):
        ray = along[first : first + step, None]
        normal = np.cross(ray, edge_c[None])
        size = (normal * edge_b).sum(axis=2)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = (normal * offset).sum(axis=2) / size
            v = (ray * across).sum(axis=2) / size
            far = height / size
            hits = (np.abs(size) > 1e-12) & (u >= 0) & (v >= 0) & (u + v <= 1) & (far > 0)
        found[first : first + step] = np.where(hits, far, np.inf).min(axis=1)
    return found


def _side_of(place: np.ndarray, start: np.ndarray, low: np.ndarray, high: np.ndarray) -> Bool[np.ndarray, " n"]:
    """Return on which half of the side that looks at the camera rays enter."""
    middle = (low + high) / 2.0
    # The side that is approached: the one that the camera stands before most clearly.
    beyond = np.abs(start[:2] - middle[:2]) - (high - low)[:2] / 2.0
    across = 1 - int(beyond.argmax())
    half: Bool[np.ndarray, " n"] = place[:, across] > middle[across]
    return half


_SURFACE_SAMPLES = 8000


class Watcher:
    """Looks at estimates.

    Args:
        mesh_of: Returns the CAD surface (m, object frame) of an obj_id, or None of an object without one.
        seed: Decides which readings and samples are used.
    """

    def __init__(self, mesh_of: Callable[[int], TriangleMesh | None], seed: int = 0) -> None:
        self._mesh_of, self._seed = mesh_of, seed
        self._surface = cache(self._sampled)

    def __call__(self, images: Sequence[RgbdImage], estimates: Sequence[PoseEstimate]) -> list[Look | None]:
        """Return what is seen of each estimate; None where there is no CAD surface or no reading.

        Args:
            images: All in which something was estimated.
            estimates: What was estimated in them.
        """
        by_place = {(image.scene_id, image.image_id): image for image in images}
        return [self._look(by_place[item.scene_id, item.image_id], item) for item in estimates]

    def _look(self, image: RgbdImage, estimate: PoseEstimate) -> Look | None:
        surface, seen = self._surface(estimate.obj_id), _detection_of(image, estimate.detection)
        if surface is None or seen is None:
            return None
        mask, agreed, confidence = seen.pixels(*image.depth.shape), estimate.agreement, estimate.score
        if agreed is not None and agreed.confidence is not None:
            # Features of their own say what the depth image says, which the score counts too.
            confidence = agreed.confidence * seen.score
        numbers = self._seed, image.scene_id, image.image_id, max(estimate.detection, 0)
        rng = np.random.default_rng(numbers)
        return look(estimate.T_camera_object, surface, image, mask, confidence, agreed, rng)

    def _sampled(self, obj_id: int) -> CadSurface | None:
        mesh = self._mesh_of(obj_id)
        return None if mesh is None else seeded_surface(mesh, obj_id, self._seed, _SURFACE_SAMPLES)


def _detection_of(image: RgbdImage, number: int) -> Detection | None:
    """Return the detection that estimates call ``number``; None where there is none."""
    for position, item in enumerate(image.detections):
        if item.number_at(position) == number:
            return item
    return None


NINE_OF_TEN = 1.2815515655446004
"""Quantile of the normal distribution at 90 %."""


class WithUncertainty(WrappedEstimator):
    """Estimate with another estimator, look at the result, and say what is thought of it.

    Args:
        inner: The other.
        model: What features mean.
        meshes: CAD surfaces (m, object frame) by obj_id; those of a dataset that it is shown come on top.
        reject: Largest risk (1 - score) of an estimate that is given; None rejects nothing.
        seed: Decides which readings are looked at.
        reject_blocked: Reject, too, where something stands in an opening of the object.
    """

    def __init__(
        self,
        inner: PoseEstimator,
        model: UncertaintyModel,
        meshes: Mapping[int, TriangleMesh] | None = None,
        reject: float | None = None,
        seed: int = 0,
        reject_blocked: bool = False,
    ) -> None:
        super().__init__(inner)
        self._model, self._reject = model, reject
        self._meshes, self._infos = dict(meshes or {}), dict[int, ObjectInfo]()
        self._seed, self._reject_blocked = seed, reject_blocked
        self._watcher = Watcher(self._mesh, seed)

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Show the CAD models of a dataset to the estimator, if it requires them, and take their surfaces."""
        if self.inner.learns_objects:
            self.inner.onboard(objects)
            self._infos = dict(objects)
            self._watcher = Watcher(self._mesh, self._seed)

    def estimate(self, image: RgbdImage | Observation) -> list[PoseEstimate]:
        """Return the poses in one image."""
        return self.estimate_all([observed(self, image)])

    def estimate_all(self, images: Sequence[RgbdImage]) -> list[PoseEstimate]:
        """Return the poses in several images, rejected ones among them, with a score of 0."""
        found = self.inner.estimate_all(images)
        looks = self._watcher(images, found)
        trust = {
            (image.scene_id, image.image_id, item.number_at(i)): item.score
            for image in images
            for i, item in enumerate(image.detections)
        }
        by_place = {(image.scene_id, image.image_id): image for image in images}
        return [
            self._judged(
                replace(item, rejected=item.rejected or self._is_blocked(item, by_place[item.scene_id, item.image_id])),
                seen,
                trust.get((item.scene_id, item.image_id, item.detection), 1.0),
            )
            for item, seen in zip(found, looks, strict=True)
        ]

    def _is_blocked(self, estimate: PoseEstimate, image: RgbdImage) -> bool:
        """Return whether something stands in an opening of the object, if that rejects it."""
        mesh, T = self._mesh(estimate.obj_id), estimate.T_camera_object
        if not self._reject_blocked or mesh is None or T[2, 3] <= 0.0:
            return False
        rng = np.random.default_rng([self._seed, image.scene_id, image.image_id, max(estimate.detection, 0)])
        return look_into(T, mesh, image, rng).blocked

    def _judged(self, estimate: PoseEstimate, seen: Look | None, detection_score: float) -> PoseEstimate:
        if seen is None:
            # Nothing speaks for it: who rejects risks rejects it.
            kept = self._reject is None and not estimate.rejected
            return estimate if kept else replace(estimate, score=0.0, rejected=True)
        right = self._model.probability(seen.features)
        factor = self._model.bound_factor(seen.features)
        of_readings = rms_quantile(seen.covariance, seen.metric, NINE_OF_TEN)
        rejected = estimate.rejected or (self._reject is not None and 1.0 - right > self._reject)
        return replace(
            estimate,
            score=0.0 if rejected else right * detection_score,
            predicted_error=self._model.median_factor(seen.features) * of_readings,
            error_bound=factor * of_readings,
            covariance=factor**2 * seen.covariance,
            rejected=rejected,
        )

    def _mesh(self, obj_id: int) -> TriangleMesh | None:
        if obj_id in self._infos:
            info = self._infos[obj_id]
            return info.mesh() if info.has_cad else None
        return self._meshes.get(obj_id)
