"""Where the detections of a dataset's images come from: its true masks, or detectors and segmenters by name."""

import time
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.estimators import PoseEstimator
from warehouse_sim.estimators.front_ends import open_front_end
from warehouse_sim.estimators.gravity import GravitySource, down_from_floor
from warehouse_sim.estimators.lidar.image import with_lidar_depth
from warehouse_sim.estimators.lidar.source import DepthSource
from warehouse_sim.estimators.rgbd_image import Detection, RgbdImage
from warehouse_sim.estimators.visibility import LeastVisible
from warehouse_sim.geometry.pose import transform_points

TRUTH, TRUTH_BOXES = "truth", "truth-boxes"


class Finder:
    """Reads images of a dataset with what is detected in them that an estimator can take.

    Args:
        names: Names or run folders of detectors and segmenters joined by +, each working on what the one before found;
            the first may be "truth" or "truth-boxes", what the dataset says.
        gravity: Who says where down is.
        depth: Whose depth is seen; None asks the estimator for its ``depth_source``, the camera's if it has none.

    Raises:
        UnknownNameError: A name is neither of a detector nor of a segmenter.
    """

    def __init__(self, names: str = TRUTH, gravity: GravitySource = "rig", depth: DepthSource | None = None) -> None:
        self._gravity, self._depth = gravity, depth
        first, *more = names.split("+")
        self._truth = first if first in (TRUTH, TRUTH_BOXES) else None
        self._stages = [open_front_end(name) for name in (more if self._truth else [first, *more])]
        self.seconds = 0.0
        """How long the last image's detection and the filling of its depth took."""

    def find(self, estimator: PoseEstimator, reader: DatasetReader, image: ImageRecord) -> RgbdImage | None:
        """Return an image with its detections; None where there are none.

        Raises:
            DatasetError: The LiDAR's depth is asked for, and the dataset holds no sweep of the image.
        """
        if self._truth is None:
            given: RgbdImage | None = RgbdImage.from_dataset(reader, image, ())
        else:
            given = _with_truth(estimator, reader, image, self._truth == TRUTH_BOXES)
        if given is None:
            return None
        found = self._with_gravity(given)
        sweep = self._sweep(estimator, reader, image)
        started = time.perf_counter()
        if sweep is not None:
            found = with_lidar_depth(found, sweep, self._source(estimator))
        for stage in self._stages:
            found = replace(found, detections=tuple(stage(found)))
        self.seconds = time.perf_counter() - started if self._stages or sweep is not None else 0.0
        # Estimates refer to what the detector found, whatever of it is estimated.
        numbered = tuple(_numbered(item, position) for position, item in enumerate(found.detections))
        taken = tuple(item for item in numbered if _is_known(estimator, item))
        return replace(found, detections=taken) if taken else None

    def _source(self, estimator: PoseEstimator) -> DepthSource:
        made_for: DepthSource = getattr(estimator, "depth_source", "camera")
        return self._depth or made_for

    def _sweep(
        self, estimator: PoseEstimator, reader: DatasetReader, image: ImageRecord
    ) -> Float[np.ndarray, "n 3"] | None:
        """Return the main LiDAR's points in the camera's frame (m); None where they are not asked for."""
        if self._source(estimator) == "camera":
            return None
        mounted = reader.sweep(image)
        if mounted is None:
            raise DatasetError(
                f"{reader.root}: holds no sweep of image {image.scene_id}/{image.image_id} for --depth "
                f"{self._source(estimator)}; generate it with a LiDAR and the format kitti, or take --depth camera"
            )
        return transform_points(mounted.T_camera_sensor, mounted.reading.points.astype(float))

    def _with_gravity(self, image: RgbdImage) -> RgbdImage:
        if self._gravity == "rig":
            return image
        if self._gravity == "none":
            return replace(image, gravity=None)
        rng = np.random.default_rng([image.scene_id, image.image_id])
        return replace(image, gravity=down_from_floor(image.camera, image.depth, rng))


def _with_truth(estimator: PoseEstimator, reader: DatasetReader, image: ImageRecord, boxes: bool) -> RgbdImage | None:
    """Read an image with the masks, or boxes, of those targets that the estimator knows and that are seen, if any."""
    least: LeastVisible = getattr(estimator, "least_visible", LeastVisible())
    known = None if estimator.objects is None else {shape.obj_id for shape in estimator.objects}
    # What has no pose is of an object that nobody named: it is estimated as each that the estimator knows.
    named = [item for item in image.targets if known is None or not item.has_pose or item.obj_id in known]
    targets = [item for item in named if least.takes(item)]
    if not targets:
        return None
    reads_rgb = getattr(estimator, "reads_rgb", True)
    if not boxes:
        return RgbdImage.from_dataset(reader, image, targets, rgb=reads_rgb)
    found = (
        Detection(None, item.obj_id if item.has_pose else None, number=item.gt_index, box_xyxy=item.box_visible_xyxy)
        for item in targets
    )
    return replace(RgbdImage.from_dataset(reader, image, (), rgb=reads_rgb), detections=tuple(found))


def _is_known(estimator: PoseEstimator, detection: Detection) -> bool:
    if estimator.objects is None:
        return True
    if detection.model is None:
        classes = {getattr(shape, "class_name", "") for shape in estimator.objects}
        return detection.class_name in ("", *classes) or classes == {""}
    return any(detection.model in (shape.obj_id, shape.name) for shape in estimator.objects)


def _numbered(detection: Detection, position: int) -> Detection:
    return detection if detection.number is not None else replace(detection, number=position)
