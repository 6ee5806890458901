"""An estimator with uncertainty: another's poses with a score that ranks, a covariance and a bound, or rejected."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators import BatchedPoseEstimator, KnownObject, Onboarding, PoseEstimator
from warehouse_sim.estimators.pose.uncertainty.blocked import look_into
from warehouse_sim.estimators.pose.uncertainty.covariance import rms_quantile
from warehouse_sim.estimators.pose.uncertainty.features import Look
from warehouse_sim.estimators.pose.uncertainty.model import UncertaintyModel
from warehouse_sim.estimators.pose.uncertainty.watch import Watcher
from warehouse_sim.estimators.rgbd_image import RgbdImage
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema import Observation, PoseEstimate

NINE_OF_TEN = 1.2815515655446004
"""Quantile of the normal distribution at 90 %."""


class WithUncertainty:
    """Estimate with another estimator, look at the result, and say what is thought of it.

    Whatever else the other has is requested of it.

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
        self._inner, self._model, self._reject = inner, model, reject
        self._meshes, self._infos = dict(meshes or {}), dict[int, ObjectInfo]()
        self._seed, self._reject_blocked = seed, reject_blocked
        self._watcher = Watcher(self._mesh, seed)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name == "_inner":
            raise AttributeError(name)
        return getattr(self._inner, name)

    @property
    def objects(self) -> Sequence[KnownObject] | None:
        """What it knows; None where it takes any object."""
        return self._inner.objects

    def onboard(self, objects: Mapping[int, ObjectInfo]) -> None:
        """Show the CAD models of a dataset to the estimator, if it asks for them, and take their surfaces."""
        if isinstance(self._inner, Onboarding):
            self._inner.onboard(objects)
            self._infos = dict(objects)
            self._watcher = Watcher(self._mesh, self._seed)

    def estimate(self, image: RgbdImage | Observation) -> list[PoseEstimate]:
        """Return the poses in one image."""
        return self.estimate_all([self._taken(image) if isinstance(image, Observation) else image])

    def estimate_all(self, images: Sequence[RgbdImage]) -> list[PoseEstimate]:
        """Return the poses in several images, rejected ones among them, with a score of 0."""
        if isinstance(self._inner, BatchedPoseEstimator):
            found = self._inner.estimate_all(images)
        else:
            found = [estimate for image in images for estimate in self._inner.estimate(image)]
        looks = self._watcher(images, found)
        trust = {
            (image.scene_id, image.image_id, i if item.number is None else item.number): item.score
            for image in images
            for i, item in enumerate(image.detections)
        }
        return [
            self._judged(item, seen, trust.get((item.scene_id, item.image_id, item.detection), 1.0))
            for item, seen in zip(self._with_room(images, found), looks, strict=True)
        ]

    def _with_room(self, images: Sequence[RgbdImage], found: Sequence[PoseEstimate]) -> list[PoseEstimate]:
        """Return the estimates, rejected where something stands in an opening of the object."""
        if not self._reject_blocked:
            return list(found)
        by_place = {(image.scene_id, image.image_id): image for image in images}
        return [self._requested_clearance(item, by_place[item.scene_id, item.image_id]) for item in found]

    def _requested_clearance(self, estimate: PoseEstimate, image: RgbdImage) -> PoseEstimate:
        mesh, T = self._mesh(estimate.obj_id), estimate.T_camera_object
        rng = np.random.default_rng([self._seed, image.scene_id, image.image_id, max(estimate.detection, 0)])
        if mesh is None or T[2, 3] <= 0.0 or not look_into(T, mesh, image, rng).blocked:
            return estimate
        return replace(estimate, rejected=True)

    def _judged(self, estimate: PoseEstimate, seen: Look | None, detection_score: float) -> PoseEstimate:
        if seen is None:
            # Nothing speaks for it: who rejects risks rejects it.
            return (
                estimate
                if self._reject is None and not estimate.rejected
                else replace(estimate, score=0.0, rejected=True)
            )
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

    def _taken(self, observation: Observation) -> RgbdImage:
        image = RgbdImage.from_observation(observation)
        if self.objects is None:
            return image
        known = {shape.obj_id for shape in self.objects}
        return replace(image, detections=tuple(item for item in image.detections if item.model in known))
