"""Rays of a pinhole camera through the squares of its pixels."""

from typing import Any

import drjit as dr
import mitsuba as mi

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.pathtrace.sobol import SobolSampler, sobol_sampler


def camera_rays(
    camera: PinholeCamera, T_world_camera: Transform, seed: int, first: int, count: int
) -> "tuple[mi.Ray3f, SobolSampler]":
    """Return unit rays, ``count`` a pixel, one pixel after the other, and the sampler that goes on with their paths.

    Args:
        camera: Intrinsics.
        T_world_camera: Pose of the camera.
        seed: Of all random numbers.
        first: Number of the first path of each pixel: those of an image are spread evenly over the square.
        count: Paths a pixel.
    """
    path = dr.arange(mi.UInt32, camera.width * camera.height * count)
    per_pixel = dr.opaque(mi.UInt32, count)
    pixel = path // per_pixel
    sampler = sobol_sampler(seed, pixel, path - pixel * per_pixel + dr.opaque(mi.UInt32, first))
    row = pixel // camera.width
    column = pixel - row * camera.width
    jitter = sampler.next_2d() - 0.5
    x = (mi.Float(column) + jitter.x - camera.cx) / camera.fx
    y = (mi.Float(row) + jitter.y - camera.cy) / camera.fy
    axes: list[Any] = [mi.Vector3f(*map(float, T_world_camera[:3, axis])) for axis in range(4)]
    right, down, forward, origin = axes
    return mi.Ray3f(mi.Point3f(origin), dr.normalize(right * x + down * y + forward)), sampler
