"""Which lamps matter, and how bright they make what a scene's viewpoints look at."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64

from warehouse_sim.scene.lighting.photometry import relative_intensity
from warehouse_sim.schema import Light, SceneSpec, Viewpoint

GROUND = 0.3
"""How bright the lower half of the even environment is, as a share of the upper half."""
_AHEAD = 4.0  # metres before a camera where its picture is taken to be


def even_illuminance(scene: SceneSpec) -> float:
    """Return the illuminance (lx) of the even environment, averaged over the directions that a surface may face."""
    return scene.ambient * (1.0 + GROUND) / 2.0


def lamp_geometry(light: Light) -> bytes:
    """Return all of a lamp but its intensity and colour: lamps that agree in it light and shade the same places."""
    numbers = [*light.position, *light.direction, light.cone_inner, light.cone_outer, light.radius, light.casts_shadow]
    return light.kind.encode() + np.array(numbers, float).tobytes()


def points_before(viewpoints: Sequence[Viewpoint]) -> Float64[np.ndarray, "n 3"]:
    """Return a point (m, world) some metres before each viewpoint: where its picture is taken to be."""
    poses = [viewpoint.T_world_camera for viewpoint in viewpoints]
    return np.array([T[:3, 3] + _AHEAD * T[:3, 2] for T in poses]).reshape(-1, 3)


def importance(light: Light, points: Float64[np.ndarray, "n 3"]) -> float:
    """Return the illuminance (lx) that ``light`` could give at ``points`` (m, world) if it shone there, on average."""
    squared = ((points - np.asarray(light.position, float)) ** 2).sum(axis=1)
    return light.intensity * float(np.mean(1.0 / np.maximum(squared, 1.0)))


def looked_at(scene: SceneSpec) -> Float64[np.ndarray, "n 3"]:
    """Return points (m, world) some metres before the viewpoints, or before the lamps of a scene that has none."""
    if scene.viewpoints:
        return points_before(scene.viewpoints)
    return np.array([light.position + _AHEAD * light.direction for light in scene.lights], float).reshape(-1, 3)


def facing_illuminance(light: Light, points: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, " n"]:
    """Return the illuminance (lx) that ``light`` gives, without shadows, to surfaces at ``points`` that face it."""
    away = points - np.asarray(light.position, float)
    squared = np.maximum((away**2).sum(axis=1), 1.0)
    cosine = away @ np.asarray(light.direction, float) / np.sqrt(squared)
    return light.intensity * relative_intensity(light, cosine) / squared


def strongest_lights(scene: SceneSpec, count: int | None) -> list[Light]:
    """Return at most ``count`` lamps, those that light what is looked at the most, in the order of the scene."""
    if count is None or len(scene.lights) <= count:
        return list(scene.lights)
    points = looked_at(scene)
    weight = [importance(light, points) for light in scene.lights]
    chosen = sorted(range(len(weight)), key=lambda index: -weight[index])[:count]
    return [scene.lights[index] for index in sorted(chosen)]
