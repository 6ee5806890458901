"""Which lights matter, what they reach, and how bright they make the places that a scene is looked at for."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32, Float64, Int

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.light_grid import CoarseScene, aisle_places
from warehouse_sim.scene.lighting.photometry import relative_intensity
from warehouse_sim.schema import Light, SceneSpec

GROUND = 0.3
"""How bright the lower half of the even environment is, as a fraction of the upper half."""
WIDE_FROM, WIDE_TO = np.deg2rad(64.0), np.deg2rad(70.0)
"""Angles from a light's axis over which shadow maps hand it over to what is gathered on a grid: a flat map that went on
to 85 deg would have four times as large texels all over, and a lamp sends a few percent of its light there."""
_AHEAD = 4.0  # metres before a camera where its image is taken to be
_NEAREST = 1.0  # metres from a lamp within which points get no more of it


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


@dataclass(frozen=True, eq=False)
class LightReach:
    """What one light reaches among some points, however bright it is."""

    lit: Int[np.ndarray, " k"]
    """Numbers of the points that it lights."""
    fraction: Float32[np.ndarray, " k"]
    """Their irradiance (lx) for each candela of the light."""


def light_reaches(
    solid: CoarseScene,
    lights: Sequence[Light],
    points: Float[np.ndarray, "n 3"],
    normals: Float[np.ndarray, "n 3"] | None,
    known: dict[bytes, LightReach],
) -> list[LightReach]:
    """Return what each of ``lights``, taken for points, reaches.

    Args:
        solid: Casts the shadows.
        lights: The lights.
        points: On surfaces, a little lifted, or anywhere (m).
        normals: Unit normals of the surfaces; None for points that gather what shadow maps do not show.
        known: What lights reach among these very points; those that are new are added.
    """
    keys = [light_geometry(light) + bytes([light.fill]) for light in lights]
    for key, light in zip(keys, lights, strict=True):
        if key not in known:
            known[key] = _reach_of(light, solid, points, normals)
    return [known[key] for key in keys]


def direct_irradiance(
    solid: CoarseScene,
    lights: Sequence[Light],
    points: Float[np.ndarray, "n 3"],
    normals: Float[np.ndarray, "n 3"],
    known: dict[bytes, LightReach],
) -> Float32[np.ndarray, "n 3"]:
    """Return the irradiance (lx, linear RGB) that lights give surfaces; arguments as those of ``light_reaches``."""
    total = np.zeros((len(points), 3), np.float32)
    for light, reach in zip(lights, light_reaches(solid, lights, points, normals, known), strict=True):
        total[reach.lit] += light.intensity * reach.fraction[:, None] * np.asarray(light.color, np.float32)
    return total


def _reach_of(
    light: Light, solid: CoarseScene, points: Float[np.ndarray, "n 3"], normals: Float[np.ndarray, "n 3"] | None
) -> LightReach:
    """Return what a light reaches: cos(incidence) / r^2; a spot fades as ``relative_intensity`` says.

    Without ``normals`` it is 1 / r^2, that of surfaces which look at the light, of what a grid gathers of it.
    """
    to_light = (np.asarray(light.position, float) - points).astype(np.float32)
    squared = np.einsum("ij,ij->i", to_light, to_light)
    distance = np.sqrt(squared)
    cosine = np.einsum("ij,j->i", to_light, -np.asarray(light.direction, np.float32)) / distance
    if normals is None:
        # Such a point stands for a cell about it, of which a lamp beside it lights a part only.
        fraction = wide_fraction(light, cosine) / np.maximum(squared, _NEAREST**2)
    else:
        fraction = np.einsum("ij,ij->i", to_light, normals) / (distance * squared)
    fraction *= relative_intensity(light, cosine, -to_light / distance[:, None])
    lit = np.flatnonzero(fraction > 0.0)
    if light.casts_shadow:
        lit = lit[~solid.blocked(points[lit], to_light[lit])]
    return LightReach(lit, fraction[lit].astype(np.float32))


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
