"""Layers that carry another layer or load have all the pieces of their pattern."""

from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog.loads.strength import is_goods
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene.sampling import sample_scene
from warehouse_sim.schema import SceneSpec

FULL = 0.85


def layers_of(scene: SceneSpec) -> dict[int, dict[float, float]]:
    """Return for each load of one article the base area (m^2) of its pieces by the height of their tops (m)."""
    loads: dict[int, dict[float, float]] = defaultdict(lambda: defaultdict(float))
    articles: dict[int, set[tuple[float, ...]]] = defaultdict(set)
    for item in scene.instances:
        model = scene.model_of(item)
        if item.dynamic and is_goods(model):
            top = float(item.T_world_object[2, 3] + model.size[2] / 2)
            articles[item.group].add(tuple(model.size))
            loads[item.group][round(top, 2)] += float(np.prod(model.size[:2]))
    return {group: levels for group, levels in loads.items() if len(articles[group]) == 1}


@pytest.mark.parametrize("name", ["block_storage", "dock_staging"])
def test_layers_below_others_and_below_loads_are_full(name: str) -> None:
    recipe = replace(load_recipe(name).scene, observations_per_scene=1)
    assert sum(full_layers(sample_scene(recipe, 3, number)) for number in (1, 2, 3)) > 20


def full_layers(scene: SceneSpec) -> int:
    """Return how many layers that bear others or loads are full, all of them."""
    loads = layers_of(scene)
    feet = [
        item.T_world_object[:3, 3] - [0.0, 0.0, scene.model_of(item).size[2] / 2]
        for item in scene.instances
        if scene.model_of(item).class_name == "pallet"
    ]
    centres = {item.group: item.T_world_object[:2, 3] for item in scene.instances}
    below = 0
    for group, levels in loads.items():
        order = sorted(levels)
        under_a_load = any(
            abs(foot[2] - order[-1]) < 0.05 and np.linalg.norm(foot[:2] - centres[group]) < 0.2 for foot in feet
        )
        # A load under another one has no lower layer to hold it against but those of its own pattern.
        for level in order if under_a_load else order[:-1]:
            assert levels[level] >= FULL * max(levels.values()), (group, level)
            below += 1
    return below
