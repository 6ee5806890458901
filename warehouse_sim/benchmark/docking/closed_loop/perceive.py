"""Who estimates the pallet on the way: ground truth, or an estimator that sees what the truck's camera sees."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.benchmark.docking.closed_loop.drive import Glance
from warehouse_sim.benchmark.docking.closed_loop.live import LiveScene
from warehouse_sim.estimators.api import FrontEnd, PoseEstimator
from warehouse_sim.estimators.gravity import down_of_camera
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.matching import taken_by
from warehouse_sim.estimators.tracking.tracker import View, in_sight
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.schema import ObjectInstance, ObjectModel, PoseEstimate

_LEAST_PIXELS = 32
"""As estimators ask of a dataset's ground-truth masks."""
_FROM_COMMANDED, _NEAR = 0.5, 0.4
"""What a front end finds is the truck's if it lies within this (m) of where it was sent, or believes it."""


def nominal(sigma: float, turn_deg: float) -> Float[np.ndarray, "6 6"]:
    """Return the covariance of estimates that state none: by place (m) and by turn (deg), standard deviations."""
    return np.diag([sigma**2] * 3 + [float(np.deg2rad(turn_deg)) ** 2] * 3)


@dataclass(frozen=True, eq=False)
class Oracle:
    """Knows the pallet while it is in sight; ``T_object_wrong`` makes it wrong by always the same."""

    pallet: ObjectInstance
    model: ObjectModel
    camera: PinholeCamera
    T_object_wrong: Transform | None = None
    min_score: float = 0.0

    def __call__(self, glance: Glance) -> PoseEstimate | None:
        """Return the true pose in the camera frame."""
        T_world_camera = glance.viewpoint.T_world_camera
        here = View(0, glance.index, self.camera, T_world_camera, glance.viewpoint.time)
        if not in_sight(here, self.pallet.T_world_object[:3, 3]):
            return None
        T = invert(T_world_camera) @ self.pallet.T_world_object
        T = T if self.T_object_wrong is None else T @ self.T_object_wrong
        return PoseEstimate(0, glance.index, self.model.obj_id, 1.0, T, covariance=nominal(0.002, 0.1))


@dataclass(frozen=True, eq=False)
class Seen:
    """An estimator on live images.

    Args:
        live: Renders what the truck sees.
        estimator: Estimates poses.
        pallet: The truck's.
        model: Its geometry.
        front_end: What finds objects in the image, one after the other; none takes the ground-truth mask of the pallet.
        commanded: Where the truck was sent (m, world), to choose among detections.
        number: Of the approach; images of one scene have numbers of their own.
        min_score: Scores below this do not count, of estimators whose uncertainty was fitted; a score without
            uncertainty is no probability, and counts whatever it is.
        sigma: What is taken for the covariance where the estimator states none.
    """

    live: LiveScene
    estimator: PoseEstimator
    pallet: ObjectInstance
    model: ObjectModel
    front_end: Sequence[FrontEnd]
    commanded: Float[np.ndarray, " 3"]
    number: int
    min_score: float
    sigma: tuple[float, float] = (0.02, 1.5)

    def __call__(self, glance: Glance) -> PoseEstimate | None:
        """Return the estimate of the pallet that the truck was sent to."""
        shot = self.live.shoot(glance.viewpoint, glance.driven, f"closed loop {self.number} {glance.index}")
        image = RgbdImage(
            shot.camera,
            shot.depth,
            (),
            shot.rgb,
            shot.scene_index,
            1000 * self.number + glance.index,
            glance.T_odom_camera,
            down_of_camera(glance.T_odom_camera),
        )
        image = self._with_detections(image, shot.instance_mask == self.pallet.instance_id)
        if not image.detections:
            return None
        found = [item for item in self.estimator.estimate(image) if item.obj_id == self.model.obj_id]
        found = found if not self.front_end else self._mine(found, glance)
        if not found:
            return None
        best = max(found, key=lambda item: item.score)
        if best.covariance is not None:
            return best
        return replace(best, covariance=nominal(*self.sigma), score=max(best.score, self.min_score))

    def _with_detections(self, image: RgbdImage, mask: np.ndarray) -> RgbdImage:
        if not self.front_end:
            seen = int(mask.sum()) >= _LEAST_PIXELS
            mine = Detection(mask, self.model.obj_id, number=self.pallet.instance_id)
            return replace(image, detections=(mine,) if seen else ())
        for stage in self.front_end:
            image = replace(image, detections=tuple(stage(image)))
        return replace(image, detections=taken_by(self.estimator, image.detections, (self.model.name,)))

    def _mine(self, found: Sequence[PoseEstimate], glance: Glance) -> list[PoseEstimate]:
        known = glance.T_odom_object
        at, most = (self.commanded, _FROM_COMMANDED) if known is None else (known[:3, 3], _NEAR)
        away = [float(np.linalg.norm((glance.T_odom_camera @ item.T_camera_object)[:3, 3] - at)) for item in found]
        near = [pair for pair in zip(away, found, strict=True) if pair[0] <= most]
        return [min(near, key=lambda pair: pair[0])[1]] if near else []
