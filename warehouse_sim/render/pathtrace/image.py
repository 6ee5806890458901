"""Many paths a pixel become an image."""

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.pathtrace.camera_rays import camera_rays
from warehouse_sim.render.pathtrace.integrator import trace_paths
from warehouse_sim.render.pathtrace.loaded_scene import LoadedScene

_PATHS_AT_ONCE = 2_000_000
_BRIGHTEST_INDIRECT = 20.0  # linear image value, of which 1 is white


def trace_image(
    scene: LoadedScene, camera: PinholeCamera, T_world_camera: Transform, samples: int, seed: int, bounces: int
) -> Float[np.ndarray, "h w 3"]:
    """Return the mean luminance (cd/m^2) of three channels over the square of each pixel.

    Args:
        scene: What light meets.
        camera: Intrinsics.
        T_world_camera: Pose of the camera.
        samples: Paths a pixel.
        seed: Of all random numbers.
        bounces: Reflections after the first surface that are followed.
    """
    pixels = camera.width * camera.height
    largest = max(1, min(samples, _PATHS_AT_ONCE // pixels))
    limit = dr.opaque(mi.Float, _BRIGHTEST_INDIRECT / scene.exposure)
    total = np.zeros((pixels, 3))
    for first in range(0, samples, largest):
        count = min(largest, samples - first)
        ray, sampler = camera_rays(camera, T_world_camera, seed, first, count)
        light = trace_paths(scene, ray, sampler, dr.opaque(mi.UInt32, bounces), limit)
        total += light.numpy().T.reshape(pixels, count, 3).sum(axis=1)
    return (total / samples).reshape(camera.height, camera.width, 3)
