"""``lidar-direct``: poses from a LiDAR's sweep as it is. Boxes of its range image, points, clusters, a network.

No camera takes part: each object is looked at from the LiDAR, in a level frame that faces it.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.api import Composition, KnownObject, LeastVisible, PoseEstimator
from warehouse_sim.estimators.detections import AUTO
from warehouse_sim.estimators.image import Detection, RgbdImage, SweepView
from warehouse_sim.estimators.lidar.clusters import chosen_points, cluster
from warehouse_sim.estimators.lidar.pointcloud import PointChain, point_network
from warehouse_sim.estimators.lidar.projection import sparse_depth
from warehouse_sim.estimators.lidar.sweep.estimator import UPWARDS, SweepDetection, TrainedSweepDetector, require_sweep
from warehouse_sim.estimators.lidar.sweep.rows import floor_in, up_of
from warehouse_sim.estimators.lidar.sweep.view import ObjectView, facing_points, object_view
from warehouse_sim.estimators.matching import taken_by
from warehouse_sim.estimators.pipeline import WithFrontEnd
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.resources import model_dir, model_names
from warehouse_sim.schema import PoseEstimate

_LEAST_POINTS = 10
"""Of an object with fewer points nothing is said."""
_NO_CAMERA = PinholeCamera.from_focal(1, 1, 1.0)


class ViewChain(PointChain):
    """The stages of a network on views of single objects; see ``PointChain`` for the arguments."""

    def points_of(self, image: RgbdImage, crop: Crop) -> tuple[Float[np.ndarray, "n 3"], list[int]]:
        """Return the object's points as the LiDAR read them."""
        assert isinstance(image, ObjectView)
        return image.own, []


class SweepPoses(PoseEstimator):
    """Poses of what was detected in sweeps: each object's points, in a frame that faces it, for a network.

    Args:
        network: Reads points alone.
    """

    reads_sweep = True
    reads_rgb = False

    def __init__(self, network: Estimator) -> None:
        self._chain, self._network = ViewChain(network), network

    @property
    def min_visible(self) -> LeastVisible:
        """Which of a dataset's targets it takes."""
        return self._network.min_visible

    @property
    def objects(self) -> Sequence[KnownObject] | None:
        """What it knows."""
        return self._network.objects

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return the poses, in the camera frame, of an image's detections that have points enough.

        Detections of a sweep bring their points; of others, those are taken that the camera would see in their mask,
        or the cluster of them in their box.

        Raises:
            InputError: The image comes without a sweep.
        """
        started = time.perf_counter()
        sweep = require_sweep(image)
        floor = floor_in(sweep.points)
        up = UPWARDS if floor is None else up_of(floor)
        if image.gravity is not None:
            up = -sweep.T_camera_lidar[:3, :3].T @ image.gravity
        views = [self._view(sweep, position, item, up, image) for position, item in enumerate(image.detections)]
        found = [view for view in views if view is not None]
        poses = self._chain.estimate_all(found) if found else []
        of_number = {view.detections[0].number: view for view in found}
        seconds = time.perf_counter() - started
        return [
            replace(
                pose,
                T_camera_object=sweep.T_camera_lidar @ of_number[pose.detection].T_lidar_view @ pose.T_camera_object,
                time=seconds,
            )
            for pose in poses
        ]

    def _view(
        self, sweep: SweepView, position: int, item: Detection, up: Float[np.ndarray, " 3"], image: RgbdImage
    ) -> ObjectView | None:
        own = item.own if isinstance(item, SweepDetection) else points_seen_in(sweep, item, image.camera)
        if own.sum() < _LEAST_POINTS:
            return None
        T_lidar_view = facing_points(sweep.points[own], up)
        numbered = replace(item, number=item.number_at(position))
        return object_view(sweep.points, own, T_lidar_view, numbered, (image.scene_id, image.image_id))


class LidarDirect(WithFrontEnd):
    """Poses from sweeps, which brings its own detector.

    Args:
        poses: What estimates the poses.
        detector: What finds the objects.
        objects: Names of the objects that there are; all that are known by default.
    """

    reads_rgb = False

    def __init__(self, poses: SweepPoses, detector: TrainedSweepDetector, objects: Sequence[str] = ()) -> None:
        super().__init__(poses, [detector], objects)
        self._poses, self._detector = poses, detector

    def around(self, points: Float[np.ndarray, "n 3"]) -> list[PoseEstimate]:
        """Return the poses of everything that is found all around a LiDAR, ``T_camera_object`` in its own frame.

        Args:
            points: A sweep (LiDAR frame, m), in any order.
        """
        points = np.asarray(points, dtype=float)
        found = taken_by(self._poses, self._detector.around(points), self._names)
        sweep = SweepView(points, np.eye(4))
        return self._poses.estimate(RgbdImage(_NO_CAMERA, np.zeros((1, 1), np.float32), found, sweep=sweep))


@dataclass(frozen=True)
class DirectMethod(Composition):
    """What ``lidar-direct`` stands for: a bundled network behind a detector of sweeps."""

    network: str
    """The network, which must read points alone."""
    detector: str
    """Finds objects in sweeps."""
    inputs = "LiDAR sweep: range image, clusters, cloud"
    front_end = estimator = ""

    def configured(self, config: PredictConfig) -> PoseEstimator:
        """Return the estimator; where ``config`` says where detections come from, no detector is needed.

        Raises:
            TrainingError: The detector has no bundled weights.
            InputError: The network reads an image, or uncertainty was fitted for it alone.
        """
        if config.detections == AUTO and self.detector not in model_names():
            raise TrainingError(
                f"lidar-direct finds objects by {self.detector}, which has no bundled weights: train it, and predict "
                "with --detections RUN"
            )
        poses = SweepPoses(point_network(self.network, replace(config, refine=config.refine or "icp")))
        if config.detections != AUTO:
            return poses
        return LidarDirect(poses, TrainedSweepDetector(Path(model_dir(self.detector))), config.objects)


def points_seen_in(sweep: SweepView, detection: Detection, camera: PinholeCamera) -> Bool[np.ndarray, " n"]:
    """Return which points of a sweep a camera sees in a detection's mask, or of those in its box the object's."""
    points = transform_points(sweep.T_camera_lidar, sweep.points)
    shown = sparse_depth(camera, points).shown
    inside = shown[detection.pixels(*shown.shape) & (shown >= 0)]
    own = np.zeros(len(points), dtype=bool)
    if detection.mask is None and len(inside):
        assert detection.box_xyxy is not None
        left, top, right, bottom = detection.box_xyxy
        spacing = float(np.sqrt((right - left + 1.0) * (bottom - top + 1.0) / len(inside)) / camera.fx)
        inside = inside[chosen_points(points[inside], cluster(points[inside], spacing))]
    own[inside] = True
    return own


LIDAR_DIRECT = DirectMethod("densefusion-pointcloud", "detector-sweep")
"""From a LiDAR's sweep to poses, without a camera between them."""
