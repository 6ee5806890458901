"""Which lights matter, and how bright they make the places that a scene is looked at for."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Float64

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.light_grid import aisle_places
from warehouse_sim.scene.lighting.photometry import relative_intensity
from warehouse_sim.schema import Light, SceneSpec

GROUND = 0.3
"""How bright the lower half of the even environment is, as a fraction of the upper half."""
WIDE_FROM, WIDE_TO = np.deg2rad(64.0), np.deg2rad(70.0)
"""Angles from a light's axis over which shadow maps hand it over to what is gathered on a grid: a flat map that went on
to 85 deg would have four times as large texels all over, and a lamp sends a few percent of its light there."""
_AHEAD = 4.0  # metres before a camera where its image is taken to be


def even_illuminance(scene: SceneSpec) -> float:
    """Return the illuminance (lx) of the even environment, averaged over the directions that a surface may face."""
    return scene.ambient * (1.0 + GROUND) / 2.0


def light_geometry(light: Light) -> bytes:
    """Return all of a light but its intensity and colour: lights that agree in it light and shade the same places."""
    numbers = [*light.position, *light.direction, light.cone_inner, light.cone_outer, light.radius, light.casts_shadow]
    own = b"" if light.distribution is None else light.distribution.fraction.tobytes() + np.array(light.along).tobytes()
    return light.kind.encode() + np.array(numbers, float).tobytes() + own


def wide_fraction(light: Light, cosine: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    """Return the fraction of a light that is gathered on a grid, by the cosine between its axis and where it shines.

    All of a light that fills the hall, what goes far aside of one that has a shadow map, and nothing of others.
    """
    if light.fill:
        return np.ones_like(cosine)
    scale, offset = map_ramp(light)
    return 1.0 - np.clip(cosine * scale + offset, 0.0, 1.0)


def map_ramp(light: Light) -> tuple[float, float]:
    """Return scale and offset of the fraction that shadow maps keep: saturate(cosine * scale + offset)."""
    if light.kind != "spot" or not light.casts_shadow:
        return 0.0, 1.0
    near, far = float(np.cos(WIDE_FROM)), float(np.cos(WIDE_TO))
    return 1.0 / (near - far), -far / (near - far)


def point_ahead(T_world_camera: Transform) -> Float64[np.ndarray, "1 3"]:
    """Return the point (m, world) some metres before a camera where its image is taken to be."""
    return (T_world_camera[:3, 3] + _AHEAD * T_world_camera[:3, 2])[None]


def importance(light: Light, points: Float64[np.ndarray, "n 3"]) -> float:
    """Return the illuminance (lx) that ``light`` could give at ``points`` (m, world) if it shone there, on average."""
    squared = ((points - np.asarray(light.position, float)) ** 2).sum(axis=1)
    return light.intensity * float(np.mean(1.0 / np.maximum(squared, 1.0)))


def reference_points(scene: SceneSpec) -> Float64[np.ndarray, "n 3"]:
    """Return places (m, world) that a scene is looked at for: in its aisle, else at its targets, else at its lights.

    Viewpoints do not count: what is seen from one of them must not depend on the others.
    """
    if scene.aisle is not None:
        return aisle_places(scene.aisle)
    targets = [item.T_world_object[:3, 3] for item in scene.target_instances()]
    lit = [light.position + _AHEAD * light.direction for light in scene.lights]
    return np.array(targets or lit, float).reshape(-1, 3)


def facing_illuminance(light: Light, points: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, " n"]:
    """Return the illuminance (lx) that ``light`` gives, without shadows, to surfaces at ``points`` that face it."""
    away = points - np.asarray(light.position, float)
    squared = np.maximum((away**2).sum(axis=1), 1.0)
    distance = np.sqrt(squared)
    cosine = away @ np.asarray(light.direction, float) / distance
    return light.intensity * relative_intensity(light, cosine, away / distance[:, None]) / squared


def strongest_lights(lights: Sequence[Light], count: int | None, points: Float64[np.ndarray, "n 3"]) -> list[Light]:
    """Return at most ``count`` lights, those that could light ``points`` (m, world) the most, in the order given.

    Lights that fill a hall do not count: there are too many of them, and none is near.
    """
    lights = [light for light in lights if not light.fill]
    if count is None or len(lights) <= count:
        return list(lights)
    ranked = sorted(range(len(lights)), key=lambda number: -importance(lights[number], points))
    return [lights[number] for number in sorted(ranked[:count])]
