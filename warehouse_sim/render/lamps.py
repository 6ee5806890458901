"""Which lamps matter, and how bright they make what a scene's viewpoints look at."""

import numpy as np
from jaxtyping import Float64

from warehouse_sim.schema import Light, SceneSpec

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


def looked_at(scene: SceneSpec) -> Float64[np.ndarray, "n 3"]:
    """Return points (m, world) some metres before the viewpoints, or before the lamps of a scene that has none."""
    if scene.viewpoints:
        poses = [viewpoint.T_world_camera for viewpoint in scene.viewpoints]
        return np.array([T[:3, 3] + _AHEAD * T[:3, 2] for T in poses])
    return np.array([light.position + _AHEAD * light.direction for light in scene.lights], float).reshape(-1, 3)


def facing_illuminance(light: Light, points: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, " n"]:
    """Return the illuminance (lx) that ``light`` gives, without shadows, to surfaces at ``points`` that face it.

    The cone's falloff is that of glTF's KHR_lights_punctual: saturate(cos * scale + offset)^2.
    """
    away = points - np.asarray(light.position, float)
    squared = np.maximum((away**2).sum(axis=1), 1.0)
    if light.kind == "point":
        return light.intensity / squared
    inner, outer = np.cos(light.cone_inner), np.cos(light.cone_outer)
    cosine = away @ np.asarray(light.direction, float) / np.sqrt(squared)
    return light.intensity * np.clip((cosine - outer) / max(inner - outer, 1e-3), 0.0, 1.0) ** 2 / squared


def strongest_lights(scene: SceneSpec, count: int | None) -> list[Light]:
    """Return at most ``count`` lamps, those that light what is looked at the most, in the order of the scene."""
    if count is None or len(scene.lights) <= count:
        return list(scene.lights)
    points = looked_at(scene)
    importance = [light.intensity * float(np.mean(_inverse_square(light, points))) for light in scene.lights]
    chosen = sorted(range(len(importance)), key=lambda index: -importance[index])[:count]
    return [scene.lights[index] for index in sorted(chosen)]


def _inverse_square(light: Light, points: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, " n"]:
    return 1.0 / np.maximum(((points - np.asarray(light.position, float)) ** 2).sum(axis=1), 1.0)
