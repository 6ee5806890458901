"""What a denoiser reads of a view beside its colours: albedo and normals of what the camera sees, without noise.

They are means over the pixel's square, like the colours, so that edges and print lie where they lie in the image. Film
is a layer of its own albedo over what shines through, in the fractions in which it scatters and lets pass.
"""

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.pathtrace.camera_rays import camera_rays
from warehouse_sim.render.pathtrace.film import clear_fraction
from warehouse_sim.render.pathtrace.loaded_scene import LoadedScene

_LAYERS = 2  # sheets of film that are distinguished; those behind them count as clear


@dataclass(frozen=True, eq=False)
class Features:
    """Means over each pixel."""

    albedo: Float32[np.ndarray, "h w 3"]
    """Fraction of light that is scattered, 0-1; 0 where there is nothing."""
    normals: Float32[np.ndarray, "h w 3"]
    """In the world, towards the camera; shorter than 1 across edges, 0 where there is nothing."""


def cast_features(
    scene: LoadedScene, camera: PinholeCamera, T_world_camera: Transform, samples: int, seed: int
) -> Features:
    """Return the features of a view from ``samples`` rays a pixel, the camera rays of the image's first paths."""
    ray, _ = camera_rays(camera, T_world_camera, seed, 0, samples)
    hit = scene.solid.ray_intersect_preliminary(ray, coherent=True)
    albedo, normal = _surface_features(hit, ray, hit.is_valid())
    if scene.film is not None:
        albedo, normal = _through_film(scene, ray, hit.t, albedo, normal)
    shape = (camera.height, camera.width, samples, 3)
    return Features(*(values.numpy().T.reshape(shape).mean(axis=2, dtype=np.float32) for values in (albedo, normal)))


def _surface_features(hit: Any, ray: Any, active: Any) -> tuple[Any, Any]:
    surface = hit.compute_surface_interaction(ray, mi.RayFlags.All, active)
    albedo = surface.bsdf().eval_diffuse_reflectance(surface, active)
    towards = dr.mulsign(surface.n, -dr.dot(surface.n, ray.d))
    return dr.select(active, dr.clip(albedo, 0.0, 1.0), 0.0), dr.select(active, towards, 0.0)


def _through_film(scene: LoadedScene, ray: Any, solid_distance: Any, albedo: Any, normal: Any) -> tuple[Any, Any]:
    """Return albedo and normals of the scene with film, from those without."""
    assert scene.film is not None
    passed, fraction, start = mi.Float(1.0), mi.Float(1.0), ray
    front_albedo, front_normal = mi.Color3f(0.0), mi.Normal3f(0.0)
    for _ in range(2 * _LAYERS):  # a sheet has two faces
        hit = scene.film.ray_intersect_preliminary(start, coherent=False)
        travelled = dr.norm(start.o - ray.o)
        found = hit.is_valid() & (travelled + hit.t < solid_distance)
        surface = hit.compute_surface_interaction(start, mi.RayFlags.All, found)
        enters = found & (dr.dot(surface.n, ray.d) < 0.0)
        own_albedo, own_normal = _surface_features(hit, start, enters)
        passed = dr.select(enters, clear_fraction(scene, surface, hit.shape_index, enters), 1.0)
        front_albedo += fraction * (1.0 - passed) * own_albedo
        front_normal += fraction * (1.0 - passed) * own_normal
        fraction = fraction * passed
        start = surface.spawn_ray(ray.d)
        start.maxt = dr.select(found, start.maxt, 0.0)
    return front_albedo + fraction * albedo, front_normal + fraction * normal
