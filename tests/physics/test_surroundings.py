import numpy as np

from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.physics.surroundings import Surroundings
from warehouse_sim.scene import SceneRecipe, sample_scene
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig

SCENE = sample_scene(SceneRecipe(layout=RackAisleConfig(bays=1, beam_levels=(1.45,))), 0, 0)


def test_a_moved_object_takes_its_boxes_along_and_leaves_the_others() -> None:
    moved, fresh = Surroundings.of(SCENE), Surroundings.of(SCENE)
    item = next(item for item in SCENE.instances if item.dynamic)
    T = make_transform(rotation_z(0.5), np.array([1.0, 2.0, 3.0]))
    moved.move({item.instance_id: T})
    mine = moved.owner == item.instance_id
    np.testing.assert_array_equal(moved.T_world_box[~mine], fresh.T_world_box[~mine])
    np.testing.assert_allclose(moved.T_world_box[mine], T @ fresh.T_object_box[mine])
    low, high = moved.extent_of([item.instance_id])
    assert np.all(low < [1.0, 2.0, 3.0])
    assert np.all(high > [1.0, 2.0, 3.0])


def test_around_are_the_supports_and_not_the_members_or_what_is_far() -> None:
    surroundings = Surroundings.of(SCENE)
    floor = next(item.instance_id for item in SCENE.instances if item.model == "floor_slab")
    load = [item.instance_id for item in SCENE.instances if item.group == 1]
    boxes = surroundings.around(load, (0.03, 0.03, 0.06))
    assert 0 < len(boxes) < 12
    low, high = surroundings.extent_of(load)
    stood_on = [box for box in boxes if abs(box.T_parent_box[2, 3] + box.size[2] / 2 - low[2]) < 0.01]
    assert stood_on
    everything = surroundings.around([floor], (50.0, 50.0, 50.0))
    assert len(everything) == np.sum(surroundings.owner != floor)
    assert high[2] > low[2]
