"""What exact ray casting sees at integer pixel centres; shares no code with the rasteriser."""

from dataclasses import dataclass

import cv2
import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import SceneSpec


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """What exact rays see in an image."""

    instance_ids: np.ndarray
    depth: np.ndarray
    normals: np.ndarray
    """Camera frame."""

    def inside(self) -> np.ndarray:
        """Return the pixels whose 3 x 3 neighbours show the same object with the same normal, or all nothing."""
        word = self.instance_ids.astype(float)[..., None] * 10 + np.round(self.normals, 3)
        kernel = np.ones((3, 3), np.uint8)
        spread = [cv2.dilate(plane, kernel) - cv2.erode(plane, kernel) for plane in np.moveaxis(word, -1, 0)]
        # Parallel faces of one object at two depths: a step far larger than the slope of one surface explains.
        inverse = np.divide(1.0, self.depth, out=np.zeros(self.depth.shape), where=self.depth > 0)
        bend = np.abs(cv2.Laplacian(inverse, cv2.CV_64F))
        return (np.max(spread, axis=0) == 0) & (cv2.dilate(bend, kernel) < 1e-4)


def cast_image(scene: SceneSpec, camera: PinholeCamera, T_world_camera: Transform) -> GroundTruth:
    """Cast a ray through the centre of each pixel."""
    rays = camera.rays().reshape(-1, 3)
    R = T_world_camera[:3, :3]
    hits = RayCaster(scene).cast(np.broadcast_to(T_world_camera[:3, 3], rays.shape), rays @ R.T)
    shape = (camera.height, camera.width)
    # Rays have z = 1 m in the camera frame, so the distance in their own units is the z-depth.
    depth = np.where(np.isfinite(hits.distance), hits.distance, 0.0).reshape(shape)
    return GroundTruth(hits.instance_ids.reshape(shape), depth, (hits.normals @ R).reshape(*shape, 3))
