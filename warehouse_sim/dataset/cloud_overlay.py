"""Draw the points of a LiDAR into the image of a camera."""

import cv2
import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.overlay import Image, colorize_depth
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, transform_points

_NEAREST = 0.1


def draw_cloud(rgb: Image, camera: PinholeCamera, T_camera_lidar: Transform, points: Float[np.ndarray, "n 3"]) -> Image:
    """Return the image in the dark with a dot at each point that lies in it, near is warm.

    Args:
        rgb: Colour image.
        camera: Intrinsics of the image.
        T_camera_lidar: Pose of the LiDAR in the camera frame.
        points: In the frame of the LiDAR (m).
    """
    image = (rgb * 0.45).astype(np.uint8)
    seen = transform_points(T_camera_lidar, points.astype(float))
    seen = seen[seen[:, 2] > _NEAREST]
    pixels = np.round(camera.project(seen)).astype(int)
    inside = ((pixels >= 0) & (pixels < [camera.width, camera.height])).all(axis=1)
    colors = colorize_depth(seen[inside, 2][None])[0]
    for (u, v), color in zip(pixels[inside].tolist(), colors.tolist(), strict=True):
        cv2.circle(image, (u, v), 1, color, -1)
    return image
