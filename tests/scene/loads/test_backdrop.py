"""Loads in racks that nothing reaches: fixed, shared, and at rest without any simulation."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.physics.check import contact_state
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.loads.backdrop import is_backdrop
from warehouse_sim.scene.loads.shelving import ShelvingConfig
from warehouse_sim.scene.loads.staging import StagingConfig
from warehouse_sim.scene.recipe import SceneRecipe
from warehouse_sim.scene.sampling import sample_scene
from warehouse_sim.schema import SceneSpec


def scene(targets: tuple[str, ...] = ("pallet",)) -> SceneSpec:
    layout = RackAisleConfig(bays=3, rows_behind=2, sides="both", aisle_width=4.0)
    recipe = SceneRecipe(
        layout=layout,
        shelving=ShelvingConfig(empty_slot_fraction=0.1),
        staging=StagingConfig(count=Distribution.constant(0)),
        targets=targets,
        observations_per_scene=2,
    )
    return sample_scene(recipe, seed=3, scene_index=0)


@pytest.mark.parametrize("targets", [("pallet",), ("pallet", "carton")])
def test_it_rests_and_overlaps_nothing(targets: tuple[str, ...]) -> None:
    sampled = scene(targets)
    # The check looks at what is loose: for its sake what is fixed there is loose, and the rest is gone.
    parts = [item for item in sampled.instances if not item.dynamic]
    fixed = [replace(item, dynamic=is_backdrop(item)) for item in parts]
    state = contact_state(replace(sampled, instances=tuple(fixed), viewpoints=()))
    assert state.loose.size > 100
    assert state.max_overlap < 1e-6
    assert state.max_gap < 1e-6


def test_pallets_there_are_labelled_and_not_aimed_at() -> None:
    sampled = scene()
    fixed = {item.instance_id for item in sampled.instances if is_backdrop(item)}
    labelled = {item.instance_id for item in sampled.target_instances()}
    assert len(fixed & labelled) > 40
    assert not {view.target for view in sampled.viewpoints} & fixed


def test_goods_are_one_object_a_load_unless_they_are_targets() -> None:
    whole, apart = scene(), scene(("pallet", "carton"))

    def count(sampled: SceneSpec, kind: str) -> int:
        return sum(is_backdrop(item) and sampled.model_of(item).class_name == kind for item in sampled.instances)

    assert (count(whole, "carton"), count(apart, "goods")) == (0, 0)
    assert 0 < count(whole, "goods") <= count(whole, "pallet")
    assert count(apart, "carton") > count(whole, "goods")
    for name, model in whole.models.items():
        if model.class_name == "goods":
            extent = np.ptp(model.mesh().vertices, axis=0)
            assert np.all((extent <= model.size + 1e-9) & (extent > model.size - 0.003)), name
