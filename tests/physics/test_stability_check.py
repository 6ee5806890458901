"""What the stability check places against the simulation: it must stay where it was put."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.physics import SettleConfig, settle_scene
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
from warehouse_sim.schema import SceneSpec

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
