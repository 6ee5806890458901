"""Many paths a pixel become an image."""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
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
    sampler = mi.load_dict({"type": "independent"})
    limit = dr.opaque(mi.Float, _BRIGHTEST_INDIRECT / scene.exposure)
    total = np.zeros((pixels, 3))
    for number, first in enumerate(range(0, samples, largest)):
        count = min(largest, samples - first)
        # Each pass has a stream of its own: seeds of neighbouring passes must not meet those of another image's.
        sampler.seed(int(np.random.SeedSequence([seed, number]).generate_state(1)[0]), pixels * count)
        ray = _camera_rays(camera, T_world_camera, sampler, count)
        light = trace_paths(scene, ray, sampler, dr.opaque(mi.UInt32, bounces), limit)
        total += light.numpy().T.reshape(pixels, count, 3).sum(axis=1)
    return (total / samples).reshape(camera.height, camera.width, 3)


def _camera_rays(camera: PinholeCamera, T_world_camera: Transform, sampler: "mi.Sampler", count: int) -> "mi.Ray3f":
    """Return unit rays through random points of each pixel's square, ``count`` a pixel, one pixel after the other."""
    pixel = dr.arange(mi.UInt32, camera.width * camera.height * count) // count
    row = pixel // camera.width
    column = pixel - row * camera.width
    jitter = sampler.next_2d() - 0.5
    x = (mi.Float(column) + jitter.x - camera.cx) / camera.fx
    y = (mi.Float(row) + jitter.y - camera.cy) / camera.fy
    axes: list[Any] = [mi.Vector3f(*map(float, T_world_camera[:3, axis])) for axis in range(4)]
    right, down, forward, origin = axes
    return mi.Ray3f(mi.Point3f(origin), dr.normalize(right * x + down * y + forward))
