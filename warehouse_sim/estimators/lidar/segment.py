"""``cluster``, a segmenter without training: of what a box holds, the dense near cluster is the object."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.lidar.boxes import BoxPoints, box_points
from warehouse_sim.estimators.lidar.choice import chosen_points
from warehouse_sim.estimators.lidar.clusters import ClusterConfig, cluster
from warehouse_sim.estimators.rgbd_image import Detection, RgbdImage
from warehouse_sim.ranges import Range, ranged


@dataclass(frozen=True)
@ranged
class BoxClusterConfig:
    """How an object is found in its box."""

    clusters: ClusterConfig = field(default_factory=ClusterConfig)
    """What makes a cluster."""
    floor: Annotated[float, Range(0, 10, "m")] = 0.02
    """Points lower than this above the floor (m), 0-10, are the floor's where the camera's place is known; and"""
    floor_fraction: Annotated[float, Range(0, 1)] = 0.002
    """by this fraction of the range more, 0-1."""


class BoxClusters:
    """Give each detection the mask of the cluster that is chosen of its points.

    Args:
        config: Settings.
    """

    def __init__(self, config: BoxClusterConfig = BoxClusterConfig()) -> None:
        self.config = config

    def segment(self, image: RgbdImage) -> Sequence[Detection]:
        """Return the image's detections with masks; those whose box or mask holds no reading are left out.

        Raises:
            MissingPackageError: The settings ask for scikit-learn, which is not installed.
        """
        found = (self._of_one(image, position, item) for position, item in enumerate(image.detections))
        return [item for item in found if item is not None]

    def _of_one(self, image: RgbdImage, position: int, detection: Detection) -> Detection | None:
        seen = detection_points(image, detection)
        above = above_floor(image, seen.points, self.config.floor, self.config.floor_fraction)
        if not above.any():
            return None
        seen = BoxPoints(seen.points[above], seen.u[above], seen.v[above])
        clusters = cluster(seen.points, _spacing(image, seen), self.config.clusters)
        chosen = chosen_points(seen.points, clusters)
        mask = np.zeros(image.depth.shape, dtype=bool)
        mask[seen.v[chosen], seen.u[chosen]] = True
        return replace(detection, mask=mask, number=position if detection.number is None else detection.number)


def detection_points(image: RgbdImage, detection: Detection) -> BoxPoints:
    """Return the points of a detection's mask, else of its box (camera frame, m)."""
    if detection.mask is None:
        assert detection.box_xyxy is not None
        return box_points(image.camera, image.depth, detection.box_xyxy)
    v, u = np.nonzero(detection.mask & (image.depth > 0))
    return BoxPoints(image.camera.rays_at(u, v) * image.depth[v, u][:, None].astype(float), u, v)


def above_floor(
    image: RgbdImage, points: Float[np.ndarray, "n 3"], floor: float, fraction: float
) -> Bool[np.ndarray, " n"]:
    """Return which points (camera frame, m) are not of the floor z = 0; all where the camera's place is unknown."""
    if image.T_world_camera is None or np.array_equal(image.T_world_camera, np.eye(4)):
        return np.ones(len(points), dtype=bool)
    height = points @ image.T_world_camera[2, :3] + image.T_world_camera[2, 3]
    return np.asarray(height > floor + fraction * points[:, 2])


def _spacing(image: RgbdImage, seen: BoxPoints) -> float:
    """Return the angle (rad) between neighbouring readings: that of pixels, wider where few of them have one."""
    area = (seen.u.max() - seen.u.min() + 1) * (seen.v.max() - seen.v.min() + 1)
    return float(np.sqrt(max(area / len(seen.u), 1.0)) / image.camera.fx)
