"""The illuminance of a floor by random walks: a referee with other places, directions and sums than the light meter."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.color import LUMINANCE
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.lighting.photometry import light_illuminance
from warehouse_sim.schema import SceneSpec

_BOUNCES = 5
_HEADROOM = 2.5
_LIFT = 1e-3
_GROUND = 0.3


def floor_lux_by_walks(scene: SceneSpec, caster: RayCaster, walks: int, rng: np.random.Generator) -> float:
    """Return the mean illuminance (lx) of the aisle's free floor, followed over five bounces from random places.

    Args:
        scene: Lit; its aisle is known.
        caster: Rays in its geometry.
        walks: Number of places, each the start of one walk.
        rng: Source of places and directions.
    """
    points, normals = _free_places(scene, caster, walks, rng)
    paint = [scene.materials[name] for name in caster.materials]
    grey = [(1.0 - item.metallic) * float(LUMINANCE @ item.base_color) for item in paint]
    albedo, total, weight, start = np.array([*grey, 0.0]), 0.0, np.ones(len(points)), len(points)
    for _ in range(_BOUNCES):
        total += float((weight * _from_lights(scene, caster, points, normals)).sum())
        ball = rng.normal(size=points.shape)
        directions = normals + ball / np.linalg.norm(ball, axis=1, keepdims=True)  # their density falls with the cosine
        hits = caster.cast(points + _LIFT * normals, directions)
        sky = np.isinf(hits.distance)
        brightness = np.where(directions[sky, 2] > 0.0, 1.0, _GROUND)
        total += float((weight[sky] * scene.ambient * brightness).sum())
        weight = (weight * albedo[hits.materials])[~sky]
        points = (points + hits.distance[:, None] * directions)[~sky]
        directions, normals = directions[~sky], hits.normals[~sky].astype(float)
        normals *= -np.sign((normals * directions).sum(axis=1, keepdims=True))
    return total / start


def _free_places(
    scene: SceneSpec, caster: RayCaster, count: int, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
    if scene.aisle is None:
        raise ValueError("the scene does not say where its aisle is")
    x_min, x_max, y_min, y_max = scene.aisle
    places = np.column_stack([rng.uniform(x_min, x_max, count), rng.uniform(y_min, y_max, count), np.full(count, 0.01)])
    up = np.tile([0.0, 0.0, 1.0], (count, 1))
    places = places[caster.cast(places, up).distance > _HEADROOM]
    return places, up[: len(places)]


def _from_lights(
    scene: SceneSpec, caster: RayCaster, points: Float[np.ndarray, "n 3"], normals: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, " n"]:
    """Return the illuminance (lx) straight from the lights; shadows by rays that start at the light."""
    total = np.zeros(len(points))
    for light in scene.lights:
        rays = points + _LIFT * normals - light.position
        seen = caster.cast(np.tile(light.position, (len(points), 1)), rays).distance >= 0.999
        total += light_illuminance(light, points, normals) * seen
    return total
