"""Open cartons stand where the closed ones did, with nothing in their flaps, and only where it was requested."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog.loads.open_cartons import OPEN_CARTONS
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.physics import contact_state
from warehouse_sim.scene import SceneRecipe, sample_scene


def recipe(fraction: float) -> SceneRecipe:
    base = load_recipe("mixed_pallets").scene
    wear = replace(base.carton_wear, open_fraction=fraction)
    return replace(base, carton_wear=wear, observations_per_scene=1)


def test_open_cartons_keep_their_feet_and_hit_nothing() -> None:
    closed, scene = (sample_scene(recipe(fraction), 4, 1) for fraction in (0.0, 0.5))
    changed = [item for item in scene.instances if item.model in OPEN_CARTONS]
    assert len(changed) >= 5
    by_id = {item.instance_id: item for item in closed.instances}
    for item in changed:
        before = by_id[item.instance_id]
        feet = [
            one.T_world_object[2, 3] - where.model_of(one).size[2] / 2
            for one, where in ((item, scene), (before, closed))
        ]
        assert feet[0] == pytest.approx(feet[1], abs=1e-9)
        np.testing.assert_allclose(item.T_world_object[:2], before.T_world_object[:2], atol=1e-12)
    unchanged = {item.instance_id for item in scene.instances} - {item.instance_id for item in changed}
    models = {item.instance_id: item.model.partition("~")[0] for item in scene.instances}
    assert all(models[number] == by_id[number].model.partition("~")[0] for number in unchanged)
    assert contact_state(scene).max_overlap < 1e-6


def test_a_scene_with_open_cartons_stands() -> None:
    base = load_recipe("mixed_pallets")
    sampled = sample_settled_scene(replace(base, scene=recipe(0.5)), 4, 1)
    found = [item for item in sampled.scene.instances if item.model in OPEN_CARTONS]
    assert len(found) >= 5
    assert not sampled.report.problems
