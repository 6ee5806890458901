"""``detect-keypoints``: key points of pallet faces in boxes, and poses by perspective-n-point; depth is optional."""

import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from warehouse_sim.errors import InputError
from warehouse_sim.estimators.api import LeastVisible, PoseEstimator
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.matching import described
from warehouse_sim.estimators.pose.keypoints.pnp import FacePose, SeenPoints, moved_onto_face, pose_of_points
from warehouse_sim.estimators.segmenters.segnet.estimator import TrainedSegmenter, detection_edges
from warehouse_sim.estimators.segmenters.segnet.network import KnownFaces
from warehouse_sim.schema import PoseEstimate

_ERROR_PX = 4.0
"""Error at which trust falls to 1/e."""


class KeypointEstimator(PoseEstimator):
    """The key points of a run folder as a pose estimator.

    Args:
        run: Run folder, or folder of a bundled model.
        use_depth: Whether depth, where there is any, decides between near and far, and places and turns the face.

    Raises:
        TrainingError: The folder holds no complete run.
        InputError: The run was trained without key points.
    """

    min_visible = LeastVisible(0.25, 64)

    def __init__(self, run: Path, use_depth: bool = True) -> None:
        self._network, self._use_depth = TrainedSegmenter(run), use_depth
        if not self._network.run_config.objects:
            raise InputError(f"{run} was trained without key points; train keypoints-rgb")

    @property
    def objects(self) -> tuple[KnownFaces, ...]:
        """What it knows."""
        return self._network.run_config.objects

    @property
    def reads_rgb(self) -> bool:
        """Whether images need colour."""
        return self._network.reads_rgb

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        """Return a pose for each detection whose face shows four points at least.

        Raises:
            InputError: The image lacks colour.
        """
        if not image.detections:
            return []
        started = time.perf_counter()
        seen = self._network.look(image, [detection_edges(item) for item in image.detections])
        poses = list[tuple[int, FacePose]]()
        for position, item in enumerate(image.detections):
            points = SeenPoints(*seen.points(position))
            distance = self._distance(image, item, seen.probability[position]) if self._use_depth else None
            pose = pose_of_points(points, self._may_be(item), image.camera, image.gravity, distance)
            if pose is not None:
                poses.append((position, moved_onto_face(pose, image) if self._use_depth else pose))
        seconds = time.perf_counter() - started
        estimates = list[PoseEstimate]()
        for position, pose in poses:
            trust = float(np.exp(-pose.cost_px / _ERROR_PX))
            place = image, position, pose.obj_id
            estimates.append(described(*place, self.objects, trust, pose.T_camera_object, seconds))
        return estimates

    def _may_be(self, item: Detection) -> Sequence[KnownFaces]:
        requested = item.may_be if item.model is None else (item.model,)
        if requested:
            return [shape for shape in self.objects if shape.obj_id in requested or shape.name in requested]
        return [shape for shape in self.objects if item.class_name in ("", shape.class_name)]

    def _distance(self, image: RgbdImage, item: Detection, probability: np.ndarray) -> float | None:
        """Return the median depth (m) of what is likely the object in the middle of its box; None without readings."""
        left, top, right, bottom = (round(edge) for edge in detection_edges(item))
        part = image.depth[max(0, top) : max(0, bottom), max(0, left) : max(0, right)]
        valid = part[part > 0]
        return float(np.median(valid)) if valid.size else None
