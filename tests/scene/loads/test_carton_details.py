"""Some cartons are battered; places, ids and all other objects are those of the scene without."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.carton_wear import CartonWearConfig
from warehouse_sim.catalog.loads.cartons import SKUS
from warehouse_sim.catalog.loads.open_cartons import OPEN_CARTONS
from warehouse_sim.catalog.loads.stuck import BOARD_FACE, LABEL_FACE, stuck_carton
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.physics import contact_state
from warehouse_sim.scene import SceneRecipe, sample_scene
from warehouse_sim.scene.loads.carton_details import LABELS, WAYS
from warehouse_sim.schema import SceneSpec


def test_about_the_share_is_battered_and_nothing_else_changes() -> None:
    recipe = load_recipe("smoke").scene
    bare = sample_scene(recipe, 0, 1)
    rough = sample_scene(replace(recipe, carton_wear=CartonWearConfig(fraction=0.4)), 0, 1)
    cartons = battered = 0
    for a, b in zip(bare.instances, rough.instances, strict=True):
        assert (a.instance_id, a.group, a.dynamic) == (b.instance_id, b.group, b.dynamic)
        assert np.array_equal(a.T_world_object, b.T_world_object)
        assert a.model == b.model.split("~")[0]
        is_carton = bare.model_of(a).class_name == "carton"
        cartons, battered = cartons + is_carton, battered + (a.model != b.model)
        assert is_carton or a.model == b.model
    assert cartons > 10
    assert 0.1 < battered / cartons < 0.7
    assert len(rough.models) <= len(bare.models) + 3 * sum(
        model.class_name == "carton" for model in bare.models.values()
    )
    assert set(rough.models) == {item.model for item in rough.instances}


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


@pytest.fixture(scope="module")
def pair() -> tuple[SceneSpec, SceneSpec]:
    """Return one draw with fixed and with drawn prints."""
    recipe = load_recipe("smoke").scene
    sampled = replace(recipe, loads=replace(recipe.loads, prints="sampled"))
    return sample_scene(recipe, 3, 0), sample_scene(sampled, 3, 0)


def test_nothing_but_the_look_of_cartons_changes(pair: tuple[SceneSpec, SceneSpec]) -> None:
    fixed, sampled = pair
    assert len(fixed.instances) == len(sampled.instances)
    for one, other in zip(fixed.instances, sampled.instances, strict=True):
        assert one.instance_id == other.instance_id
        np.testing.assert_array_equal(one.T_world_object, other.T_world_object)
        assert fixed.model_of(one).obj_id == sampled.model_of(other).obj_id
        assert (one.model == other.model) == (one.model not in SKUS)


def test_looks_come_from_a_bounded_pool(pair: tuple[SceneSpec, SceneSpec]) -> None:
    _, sampled = pair
    cartons = [item for item in sampled.instances if sampled.model_of(item).class_name == "carton"]
    labels = {item.paint[LABEL_FACE] for item in cartons}
    assert 1 < len(labels) <= LABELS
    assert len({item.model for item in cartons}) <= WAYS * len({item.model.split("~")[0] for item in cartons})
    for item in cartons:
        for face in (LABEL_FACE, BOARD_FACE):
            assert sampled.materials[item.paint[face]].picture is not None
        for part in sampled.model_of(item).parts:
            assert item.material_of(part) in sampled.materials


@pytest.mark.parametrize("sku", SKUS)
def test_paper_and_print_stay_inside_the_outer_size(sku: str) -> None:
    model = catalog_object(sku)
    for seed in range(10):
        stuck = stuck_carton(sku, np.random.default_rng(seed))
        assert (np.abs(stuck.mesh().vertices) <= model.size / 2 + 1e-9).all()
        assert sum(part.material == LABEL_FACE for part in stuck.parts) in (1, 2)
    assert len({stuck_carton(sku, np.random.default_rng(seed)).name for seed in range(5)}) == 5
