"""What splits can be made alike in: means over the targets of each scene, measured before any image is made."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

import numpy as np
from jaxtyping import Float

from warehouse_sim.annotate import targets_in_view
from warehouse_sim.generation.executor import Work, make_scenes
from warehouse_sim.generation.light import LightMeter
from warehouse_sim.generation.occlusion.occluded_scene import OccludedScene
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.draft import Area

_RAYS = 200
"""Rays through each target; its visible fraction is then known to about 0.05."""


def scene_features(recipe: Recipe, seed: int, scene_index: int) -> Float[np.ndarray, " k"]:
    """Return the means of ``recipe.split.stratify`` over the targets in view of one scene.

    "lux" is the mean illuminance of the aisle's floor (lx), "distance" from camera to target (m).

    Raises:
        SettleError: The scene does not stand in any attempt.
    """
    scene, camera = prepare_scene(recipe, seed, scene_index).scene, recipe.sensors.make_camera()
    caster = RayCaster(scene)
    area = Area(*scene.aisle) if scene.aisle is not None else Area(0.0, 0.0, 0.0, 0.0)
    occluded = OccludedScene(scene, caster, camera, area, recipe.scene.viewpoints.clearance)
    fractions, distances = [], []
    for viewpoint in scene.viewpoints:
        for item in targets_in_view(scene, camera, viewpoint.T_world_camera):
            sight = occluded.look(item.instance_id, viewpoint.T_world_camera, _RAYS)
            if sight is not None and sight.fraction > 0.0:
                fractions.append(sight.fraction)
                distances.append(np.linalg.norm(item.T_world_object[:3, 3] - viewpoint.T_world_camera[:3, 3]))
    means = {
        "visible_fraction": float(np.mean(fractions)) if fractions else 0.0,
        "distance": float(np.mean(distances)) if distances else 0.0,
        "lux": LightMeter(scene, caster).floor_lux if "lux" in recipe.split.stratify else 0.0,
    }
    return np.array([means[name] for name in recipe.split.stratify])


def measured_features(recipe: Recipe, seed: int, scenes: int, workers: int) -> Float[np.ndarray, "n k"]:
    """Return ``scene_features`` of every scene of a dataset, one row a scene.

    Raises:
        SettleError: A scene does not stand in any attempt.
        WorkerError: A scene ended every worker that made it.
    """
    measured = dict(make_scenes(partial(_open_measure, recipe, seed), seed, range(scenes), workers))
    return np.stack([measured[index] for index in range(scenes)])


@contextmanager
def _open_measure(recipe: Recipe, seed: int) -> Iterator[Work]:
    yield partial(scene_features, recipe, seed)
