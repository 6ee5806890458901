"""``cluster``, a segmenter without training: of what a box holds, the dense near cluster is the object."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from warehouse_sim.estimators.api import Segmenter
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.lidar.clusters import chosen_points, cluster
from warehouse_sim.geometry.camera import PinholeCamera


class BoxPoints(NamedTuple):
    """Back-projected pixels."""

    points: Float[np.ndarray, "n 3"]
    """Camera frame (m)."""
    u: Int[np.ndarray, " n"]
    """Column of each point's pixel."""
    v: Int[np.ndarray, " n"]
    """Row of it."""


def box_points(
    camera: PinholeCamera, depth: Float32[np.ndarray, "h w"], box_xyxy: tuple[float, float, float, float]
) -> BoxPoints:
    """Return the points of a box, row by row.

    Args:
        camera: Of the image.
        depth: Metres along the optical axis, 0 = no reading.
        box_xyxy: Left, top, right and bottom (px); pixels whose centres lie within belong to it. It may leave the
            image.
    """
    left, top, right, bottom = box_xyxy
    first_u, first_v = max(int(np.ceil(left)), 0), max(int(np.ceil(top)), 0)
    after_u, after_v = min(int(np.floor(right)) + 1, camera.width), min(int(np.floor(bottom)) + 1, camera.height)
    part = depth[first_v : max(after_v, first_v), first_u : max(after_u, first_u)]
    v, u = np.nonzero(part > 0)
    z, u, v = part[v, u].astype(float), u + first_u, v + first_v
    return BoxPoints(camera.rays_at(u, v) * z[:, None], u, v)


FLOOR, FLOOR_FRACTION = 0.02, 0.002
"""Points lower than this above the floor (m), and by this fraction of the range more, are the floor's where the
camera's place is known."""


class BoxClusters(Segmenter):
    """Give each detection the mask of the cluster that is chosen of its points."""

    needs_detections = True
    """It outlines what boxes are about, and finds nothing by itself."""

    def segment(self, image: RgbdImage) -> Sequence[Detection]:
        """Return the image's detections with masks; those whose box or mask holds no reading are left out."""
        found = (self._of_one(image, position, item) for position, item in enumerate(image.detections))
        return [item for item in found if item is not None]

    def _of_one(self, image: RgbdImage, position: int, detection: Detection) -> Detection | None:
        seen = detection_points(image, detection)
        above = above_floor(image, seen.points)
        if not above.any():
            return None
        seen = BoxPoints(seen.points[above], seen.u[above], seen.v[above])
        clusters = cluster(seen.points, _spacing(image, seen))
        chosen = chosen_points(seen.points, clusters)
        mask = np.zeros(image.depth.shape, dtype=bool)
        mask[seen.v[chosen], seen.u[chosen]] = True
        return replace(detection, mask=mask, number=detection.number_at(position))


def detection_points(image: RgbdImage, detection: Detection) -> BoxPoints:
    """Return the points of a detection's mask, else of its box (camera frame, m)."""
    if detection.mask is None:
        assert detection.box_xyxy is not None
        return box_points(image.camera, image.depth, detection.box_xyxy)
    v, u = np.nonzero(detection.mask & (image.depth > 0))
    return BoxPoints(image.camera.rays_at(u, v) * image.depth[v, u][:, None].astype(float), u, v)


def above_floor(image: RgbdImage, points: Float[np.ndarray, "n 3"]) -> Bool[np.ndarray, " n"]:
    """Return which points (camera frame, m) are not of the floor z = 0; all where the camera's place is unknown."""
    if image.T_world_camera is None or np.array_equal(image.T_world_camera, np.eye(4)):
        return np.ones(len(points), dtype=bool)
    height = points @ image.T_world_camera[2, :3] + image.T_world_camera[2, 3]
    return np.asarray(height > FLOOR + FLOOR_FRACTION * points[:, 2])


def _spacing(image: RgbdImage, seen: BoxPoints) -> float:
    """Return the angle (rad) between neighbouring readings: that of pixels, wider where few of them have one."""
    area = (seen.u.max() - seen.u.min() + 1) * (seen.v.max() - seen.v.min() + 1)
    return float(np.sqrt(max(area / len(seen.u), 1.0)) / image.camera.fx)
