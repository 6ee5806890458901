"""Look at the estimates of whatever estimator, in the images that it was given."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators.api import PoseEstimator, WrappedEstimator
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.matching import observed
from warehouse_sim.estimators.pose.icp.surface import CadSurface, seeded_surface
from warehouse_sim.estimators.pose.uncertainty.blocked import look_into
from warehouse_sim.estimators.pose.uncertainty.covariance import rms_quantile
from warehouse_sim.estimators.pose.uncertainty.features import Look, look
from warehouse_sim.estimators.pose.uncertainty.model import UncertaintyModel
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema import Observation, PoseEstimate

_SURFACE_SAMPLES = 8000


class Watcher:
    """Looks at estimates.

    Args:
        mesh_of: Returns the CAD surface (m, object frame) of an obj_id, or None of an object without one.
        seed: Decides which readings and samples are used.
    """

    def __init__(self, mesh_of: Callable[[int], TriangleMesh | None], seed: int = 0) -> None:
        self._mesh_of, self._seed = mesh_of, seed
        self._surfaces: dict[int, CadSurface | None] = {}

    def __call__(self, images: Sequence[RgbdImage], estimates: Sequence[PoseEstimate]) -> list[Look | None]:
        """Return what is seen of each estimate; None where there is no CAD surface or no reading.

        Args:
            images: All in which something was estimated.
            estimates: What was estimated in them.
        """
        by_place = {(image.scene_id, image.image_id): image for image in images}
        return [self._look(by_place[item.scene_id, item.image_id], item) for item in estimates]

    def _look(self, image: RgbdImage, estimate: PoseEstimate) -> Look | None:
        surface, mask = self._surface(estimate.obj_id), _mask_of(image, estimate.detection)
        if surface is None or mask is None:
            return None
        numbers = self._seed, image.scene_id, image.image_id, max(estimate.detection, 0)
        rng = np.random.default_rng(numbers)
        return look(estimate.T_camera_object, surface, image, mask, estimate.score, estimate.agreement, rng)

    def _surface(self, obj_id: int) -> CadSurface | None:
        if obj_id not in self._surfaces:
            mesh = self._mesh_of(obj_id)
            found = None if mesh is None else seeded_surface(mesh, obj_id, self._seed, _SURFACE_SAMPLES)
            self._surfaces[obj_id] = found
        return self._surfaces[obj_id]


def _mask_of(image: RgbdImage, number: int) -> Bool[np.ndarray, "h w"] | None:
    """Return the pixels of the detection that estimates call ``number``; None where there is none."""
    for position, item in enumerate(image.detections):
        if item.number_at(position) == number:
            return item.pixels(*image.depth.shape)
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
