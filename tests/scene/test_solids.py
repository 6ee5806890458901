from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.physics.rest import boxes_around
from warehouse_sim.scene import SceneRecipe, sample_scene
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.solids import Solids

SCENE = sample_scene(SceneRecipe(layout=RackAisleConfig(bays=1, beam_levels=(1.45,))), 0, 0)
SOLIDS = Solids.of(SCENE.instances, SCENE.models)


def test_each_collision_box_of_the_scene_is_there_at_its_place() -> None:
    everything = SOLIDS.listed(SOLIDS.owner > 0)
    expected = [box.placed(item.T_world_object) for item in SCENE.instances for box in SCENE.model_of(item).collision]
    for found, true in zip(everything, expected, strict=True):
        np.testing.assert_array_equal(found.T_parent_box, true.T_parent_box)
        np.testing.assert_array_equal(found.size, true.size)


def test_a_moved_object_takes_its_boxes_along_and_leaves_the_others() -> None:
    item = next(item for item in SCENE.instances if item.dynamic)
    there = replace(item, T_world_object=make_transform(rotation_z(0.5), np.array([1.0, 2.0, 3.0])))
    moved, mine = SOLIDS.moved([there], SCENE.models), SOLIDS.of_objects([item.instance_id])
    fresh = Solids.of([there if one is item else one for one in SCENE.instances], SCENE.models)
    for name in ("centre", "rotation", "half"):
        np.testing.assert_array_equal(getattr(moved.boxes, name), getattr(fresh.boxes, name))
    assert not np.allclose(moved.boxes.centre[mine], SOLIDS.boxes.centre[mine])
    low, high = moved.extent_of([item.instance_id])
    assert np.all(low < [1.0, 2.0, 3.0])
    assert np.all(high > [1.0, 2.0, 3.0])


def test_many_objects_in_any_order_move_as_one_after_the_other_does() -> None:
    there = [
        replace(item, T_world_object=make_transform(rotation_z(0.1 * number), np.array([number, 2.0, 3.0])))
        for number, item in enumerate(item for item in SCENE.instances if item.dynamic)
    ][::-1]
    moved, slow = SOLIDS.moved(there, SCENE.models), SOLIDS
    for item in there:
        slow = slow.moved([item], SCENE.models)
    np.testing.assert_array_equal(moved.boxes.centre, slow.boxes.centre)
    np.testing.assert_array_equal(moved.boxes.rotation, slow.boxes.rotation)


def test_near_are_the_boxes_that_come_within_reach_on_every_axis() -> None:
    lows, highs = SOLIDS.extents
    low, high = highs[0], highs[0] + [0.5, 0.5, 0.2]  # touches the first box at a corner
    for reach in (0.0, (0.3, 0.1, 2.0)):
        expected = (lows <= high + reach).all(axis=1) & (highs >= low - reach).all(axis=1)
        assert 0 < expected.sum() < len(expected)
        np.testing.assert_array_equal(SOLIDS.near(low, high, reach), expected)


def test_around_are_the_supports_and_not_the_members_or_what_is_far() -> None:
    floor = next(item for item in SCENE.instances if item.model == "floor_slab")
    load = [item for item in SCENE.instances if item.group == 1]
    boxes = boxes_around(SOLIDS, load, (0.03, 0.03, 0.06))
    assert 0 < len(boxes) < 12
    low, high = SOLIDS.extent_of([item.instance_id for item in load])
    assert [box for box in boxes if abs(box.T_parent_box[2, 3] + box.size[2] / 2 - low[2]) < 0.01]
    assert len(boxes_around(SOLIDS, [floor], (50.0, 50.0, 50.0))) == np.sum(SOLIDS.owner != floor.instance_id)
    assert high[2] > low[2]


def test_the_gap_to_the_nearest_solid_is_that_to_each_of_them() -> None:
    box = OrientedBox(make_transform(rotation_z(0.3), np.array([0.4, -1.2, 1.0])), np.array([0.5, 0.4, 0.3]))
    each = [Solids(SOLIDS.owner[:1], SOLIDS.boxes.subset(np.arange(len(SOLIDS.owner)) == row)) for row in range(40)]
    first = SOLIDS.subset(np.arange(len(SOLIDS.owner)) < 40)
    assert first.gap(box, 30.0) == pytest.approx(min(one.gap(box, 30.0) for one in each))
    assert first.gap(box.placed(make_transform(translation=np.array([0.0, 0.0, 90.0]))), 1.0) == np.inf
    assert len(first.joined(each[0]).owner) == 41
