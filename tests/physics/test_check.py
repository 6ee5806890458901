from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z
from warehouse_sim.physics import SettleConfig, contact_state, settle_scene
from warehouse_sim.physics.impulses import ImpulseConfig
from warehouse_sim.physics.rest import RestLimits, boxes_around, bring_to_rest, find_stacks
from warehouse_sim.physics.settle import bring_stack_to_rest
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.layouts.block_storage import BlockStorageConfig
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import Layout
from warehouse_sim.scene.loads.staging import StagingConfig
from warehouse_sim.scene.recipe import SceneRecipe
from warehouse_sim.scene.sampling import sample_scene
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import ObjectInstance, SceneSpec, Viewpoint


def scene_of(*placed: tuple[str, tuple[float, float, float]]) -> SceneSpec:
    """Return a scene with a floor (instance 1) and loose objects at the given centres."""
    names = {name for name, _ in placed} | {"floor_slab"}
    floor = ObjectInstance(1, "floor_slab", make_transform(translation=np.array([0.0, 0.0, -0.1])))
    loose = [
        ObjectInstance(index + 2, name, make_transform(rotation_z(0.3), np.array(at)), dynamic=True, group=1)
        for index, (name, at) in enumerate(placed)
    ]
    models = {name: catalog_object(name) for name in names}
    return SceneSpec(0, 0, models, materials(), (floor, *loose), (), ())


@pytest.mark.parametrize("lift", [0.004, 0.0, -0.004])
def test_gap_and_overlap_of_a_pallet_on_the_floor(lift: float) -> None:
    state = contact_state(scene_of(("epal1", (0.0, 0.0, 0.072 + lift))))
    np.testing.assert_allclose(state.gap, [lift], atol=1e-9)
    assert state.max_gap == pytest.approx(max(0.0, lift), abs=1e-9)
    assert state.max_overlap == pytest.approx(max(0.0, -lift), abs=1e-9)


def test_a_tower_names_the_pair_that_overlaps_and_the_object_that_floats() -> None:
    carton = "carton_600x400x400"
    deck = 0.144 + 0.2
    state = contact_state(
        scene_of(("epal1", (0, 0, 0.072)), (carton, (0, 0, deck - 0.003)), (carton, (0, 0, deck + 0.405)))
    )
    np.testing.assert_array_equal(state.loose, [2, 3, 4])
    np.testing.assert_allclose(state.gap, [0.0, -0.003, 0.008], atol=1e-9)
    deep = state.overlap > 1e-6
    np.testing.assert_array_equal(state.pairs[deep], [[2, 3]])
    np.testing.assert_allclose(state.overlap[deep], [0.003], atol=1e-9)


def test_a_neighbour_at_the_side_does_not_carry() -> None:
    beside = scene_of(("carton_600x400x400", (0, 0, 0.2)), ("carton_600x400x400", (0.7, 0.0, 0.21)))
    assert contact_state(beside).gap[1] == pytest.approx(0.01)


def test_what_hangs_high_has_no_support_in_reach() -> None:
    assert contact_state(scene_of(("carton_600x400x400", (0, 0, 3.0)))).max_gap == pytest.approx(0.03)


def test_fixed_things_may_overlap_each_other() -> None:
    scene = scene_of(("epal1", (0.0, 0.0, 0.072)))
    sunk = replace(scene.instances[1], dynamic=False, T_world_object=make_transform(translation=np.zeros(3)))
    state = contact_state(replace(scene, instances=(scene.instances[0], sunk)))
    assert state.max_overlap == 0.0
    assert state.max_gap == 0.0


def test_what_is_below_the_floor_is_found_even_where_no_slab_is() -> None:
    scene = scene_of(("epal1", (40.0, 0.0, 0.05)))
    state = contact_state(scene)
    assert state.lowest == pytest.approx(-0.022)
    assert "object 2 is 22.0 mm below the floor" in state.problems(1.0, 1.0)


def test_a_camera_in_an_object_is_found() -> None:
    scene = scene_of(("epal1", (0.0, 0.0, 0.072)))
    views = tuple(Viewpoint(level_camera(np.array([x, 0.0, 0.1]), 0.0)) for x in (-3.0, -0.7))
    state = contact_state(replace(scene, viewpoints=views))
    assert state.blocked_viewpoints == (0, 1)  # both are also within 0.2 m of the floor
    high = tuple(Viewpoint(level_camera(np.array([x, 0.0, 0.3]), 0.0)) for x in (-3.0, 0.0))
    assert contact_state(replace(scene, viewpoints=high)).blocked_viewpoints == (1,)


# What the stability check places against the simulation: it must stay where it was put.


LIMITS = RestLimits(0.002, 0.01, 3.0)
LAYOUTS: tuple[Layout, ...] = (
    RackAisleConfig(bays=1, aisle_width=6.0),
    RackAisleConfig(bays=1, aisle_width=6.0, tolerances=True, beams="step"),
    BlockStorageConfig(lanes=2, lane_depth=2, aisle_width=6.0),
)


def sampled(layout: Layout, name: str = "block_storage") -> SceneSpec:
    """Return a scene with the loads of a shipped recipe: all patterns, totes, drums, sacks, damaged pallets."""
    loads = load_recipe(name).scene.loads
    recipe = SceneRecipe(
        layout=layout,
        loads=replace(loads, max_cartons=16),
        staging=StagingConfig(count=Distribution.constant(0)),
        observations_per_scene=1,
    )
    return sample_scene(recipe, seed=11, scene_index=0)


@pytest.mark.parametrize("layout", LAYOUTS, ids=["level beams", "tolerances", "floor"])
def test_a_stack_at_rest_by_proof_stays_there_in_the_simulation_of_each_piece(layout: Layout) -> None:
    scene = sampled(layout)
    solids = Solids.of(scene.instances, scene.models)
    placed = 0
    for stack in find_stacks(scene.instances, solids)[:12]:
        around = boxes_around(solids, stack, (0.03, 0.03, 0.06))
        found = bring_stack_to_rest(scene, stack, around, LIMITS)
        placed += found.duration == 0.0
        again = bring_to_rest(scene, found.moved(stack), around, LIMITS)
        way = [again.poses[item.instance_id][:3, 3] - found.poses[item.instance_id][:3, 3] for item in stack]
        assert np.abs(way).max() < 0.002
    assert placed > 0  # on beams that are not level, only what stands on the floor


@pytest.mark.parametrize("layout", LAYOUTS, ids=["level beams", "tolerances", "floor"])
def test_a_scene_stands_as_it_does_without_proofs(layout: Layout) -> None:
    scene, impulses = sampled(layout), ImpulseConfig(fraction=0.0)
    settled, report = settle_scene(scene, SettleConfig(impulses=impulses, stability_check=True))
    simulated, whole = settle_scene(scene, SettleConfig(impulses=impulses))
    assert report.problems == whole.problems == ()
    assert report.max_overlap < 0.001
    for one, other in zip(settled.instances, simulated.instances, strict=True):
        np.testing.assert_allclose(one.T_world_object[:3, 3], other.T_world_object[:3, 3], atol=0.004)


def test_a_load_that_would_tip_is_left_to_the_simulation() -> None:
    scene = sampled(LAYOUTS[2])
    stack = next(
        item for item in find_stacks(scene.instances, Solids.of(scene.instances, scene.models)) if len(item) > 2
    )
    top = max(stack, key=lambda item: float(item.T_world_object[2, 3]))
    shifted = top.T_world_object.copy()
    shifted[0, 3] += 0.9 * float(scene.model_of(top).size[0])
    moved = tuple(replace(item, T_world_object=shifted) if item is top else item for item in stack)
    solids = Solids.of(scene.instances, scene.models)
    found = bring_stack_to_rest(scene, moved, boxes_around(solids, stack, (0.03, 0.03, 3.0)), LIMITS)
    assert found.duration > 0.0
    assert found.poses[top.instance_id][2, 3] < shifted[2, 3] - 0.05
