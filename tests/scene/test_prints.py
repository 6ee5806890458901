"""Cartons with labels drawn again: another look, the same scene."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.cartons import SKUS
from warehouse_sim.catalog.loads.stuck import BOARD_FACE, LABEL_FACE, stuck_carton
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene.carton_details import LABELS, WAYS
from warehouse_sim.scene.sampling import sample_scene
from warehouse_sim.schema import SceneSpec


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
