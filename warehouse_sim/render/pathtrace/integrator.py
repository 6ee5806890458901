"""The path tracer: light that reaches the camera along random paths (Kajiya 1986, "The rendering equation").

At each vertex one light is rendered in proportion to its unshadowed light and asked directly; the sky is found by the
paths themselves. Lights are photometric and no surfaces, so no path meets them. Surfaces that glow are seen, and light
nothing: the ``Light`` of their luminaire holds all that it gives.
"""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.pathtrace.film import FilmEvent, film_event
from warehouse_sim.render.pathtrace.loaded_scene import LoadedScene
from warehouse_sim.render.pathtrace.sobol import SobolSampler, camera_rays

_FILM_LAYERS = 16
_ROULETTE_FROM = 2  # bounces


@dr.syntax
def trace_paths(
    scene: LoadedScene, ray: "mi.Ray3f", sampler: SobolSampler, bounces: "mi.UInt32", limit: "mi.Float"
) -> "mi.Color3f":
    """Return the luminance (cd/m^2) of three channels that comes along each ray, from one path.

    Args:
        scene: What light meets.
        ray: Camera rays in the world, of unit direction.
        sampler: Of as many paths as there are rays.
        bounces: Reflections after the first surface that are followed.
        limit: Luminance at which the fraction of a single indirect vertex is cut, against bright dots.
    """
    context = mi.BSDFContext()
    result = mi.Color3f(0.0)
    fraction = mi.Color3f(1.0)
    active = mi.Bool(True)
    seen = mi.Bool(True)  # by the camera, directly or through film
    depth = mi.UInt32(0)
    layers = mi.UInt32(0)
    while active:
        hit = scene.solid.ray_intersect_preliminary(ray, coherent=False, active=active)
        surface = hit.compute_surface_interaction(ray, mi.RayFlags.All, active)
        found = active & hit.is_valid()
        glow = dr.gather(mi.Color3f, scene.emission, hit.shape_index, found & seen)
        clear = mi.Bool(False)
        mirror = mi.Bool(False)
        on_film = mi.Bool(False)
        event: Any = None
        if dr.hint(scene.film is not None, mode="scalar"):
            event = film_event(scene, ray, hit.t, sampler, active & seen)
            on_film, clear, mirror = event.hit, event.passes, event.mirrors
            surface = dr.select(on_film, event.surface, surface)
            fraction *= event.weight
            found |= on_film
        result += dr.select(found & seen & ~on_film, fraction * glow, 0.0)
        result += dr.select(active & ~found, fraction * scene.sky.radiance(ray.d), 0.0)
        scatters = found & ~clear

        bsdf = surface.bsdf(ray)
        if dr.hint(len(scene.lights) > 0, mode="scalar"):
            light = fraction * _direct_light(scene, surface, sampler, scatters, mirror, event)
            result += dr.select(seen, light, dr.minimum(light, limit))

        sample, weight = bsdf.sample(context, surface, sampler.next_1d(), sampler.next_2d(), scatters & ~mirror)
        if dr.hint(scene.film is not None, mode="scalar"):
            sample, weight = event.sample_gloss(context, surface, sampler, sample, weight)
        fraction *= dr.select(scatters, weight, 1.0)
        ray = surface.spawn_ray(dr.select(clear, ray.d, surface.to_world(sample.wo)))
        seen &= clear
        depth += dr.select(scatters, 1, 0)
        layers += dr.select(clear, 1, 0)
        brightest = dr.max(fraction)
        active = found & (depth <= bounces) & (layers < _FILM_LAYERS) & (brightest > 0.0)
        # Russian roulette: dim paths end early, those that go on stand for them.
        survival: Any = dr.select(depth > _ROULETTE_FROM, dr.clip(brightest, 0.05, 0.95), 1.0)
        active &= sampler.next_1d() < survival
        fraction *= dr.rcp(survival)
    return result


def _direct_light(
    scene: LoadedScene, surface: Any, sampler: SobolSampler, scatters: Any, mirror: Any, event: FilmEvent | None
) -> Any:
    """Return the luminance (cd/m^2) that one drawn light gives ``surface`` towards where it is seen from.

    Args:
        scene: What light meets.
        surface: Points on surfaces or film.
        sampler: Random numbers.
        scatters: Which points scatter light.
        mirror: Which of them are clear film, that mirrors.
        event: What film there is, None in a scene without.
    """
    context = mi.BSDFContext()
    light = scene.lights.sample(surface, sampler.next_1d(), sampler.next_2d())
    local = surface.to_local(light.direction)
    value = surface.bsdf().eval(context, surface, local, scatters & ~mirror)
    if event is not None:
        value += event.evaluate_gloss(context, surface, local)
    gives = scatters & (dr.max(value) > 0.0)
    hidden = scene.solid.ray_test(surface.spawn_ray_to(light.point), gives & light.casts_shadow)
    return dr.select(gives & ~hidden, value * light.irradiance, 0.0)


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
