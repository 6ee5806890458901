from dataclasses import replace

import numpy as np
import pytest

from tests.scene.viewpoints.spaces import AREA, aisle_scene, bare_space
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import AMR, pose_on_floor

PALLET = ("epal1", (0.0, -4.0, 0.072), 0.0)


def test_a_camera_keeps_its_distance_from_things_floor_and_edge() -> None:
    space = bare_space(PALLET)
    assert space.admits_camera(np.array([1.4, -4.0, 0.5]), 0.7)
    assert not space.admits_camera(np.array([1.2, -4.0, 0.1]), 0.7)
    assert not space.admits_camera(np.array([1.2, -4.0, 0.3]), 0.7)
    assert space.admits_camera(np.array([3.0, -4.0, 0.1]), 0.7)
    assert not space.admits_camera(np.array([3.0, -4.0, 0.09]), 0.7)
    assert not space.admits_camera(np.array([3.0, -0.2, 0.5]), 0.7)


@pytest.mark.parametrize(("gap", "fits"), [(0.02, False), (0.2, True)])
def test_a_vehicle_stands_beside_a_pallet_and_not_in_it(gap: float, fits: bool) -> None:
    before = pose_on_floor(-0.6 - AMR.tip - gap, -4.0, 0.0)
    assert bare_space(PALLET).admits_bodies(AMR.boxes(before)) == fits


def test_half_of_a_pallet_behind_a_carton_wall_is_out_of_sight() -> None:
    wall = [("carton_600x400x400", (-1.0, -4.3, z), np.pi / 2) for z in (0.2, 0.6)]
    eye, open_space = np.array([-4.0, -4.0, 0.3]), bare_space(PALLET)
    assert open_space.sight_fraction(eye, open_space.targets[0]) == 1.0
    space = bare_space(PALLET, *wall)
    assert 0.2 < space.sight_fraction(eye, space.targets[0]) < 0.8


def test_leaving_out_far_boxes_does_not_change_what_is_in_sight() -> None:
    space, rng, fractions = FreeSpace.of_scene(aisle_scene(0)), np.random.default_rng(0), []
    for target in space.targets:
        eye = np.array([rng.uniform(-8, 8), rng.uniform(-9, -1), rng.uniform(0.4, 3.0)])
        size = space.models[target.model].size
        points = transform_points(target.T_world_object, np.vstack([np.zeros(3), 0.8 * box_corners(size)]))
        hidden = space.solids.boxes.subset(space.solids.owner != target.instance_id).block(eye, points)
        assert space.sight_fraction(eye, target) == np.mean(~hidden)
        fractions.append(np.mean(~hidden))
    assert min(fractions) < 0.3
    assert max(fractions) > 0.7


def test_turns_hold_every_target_once_and_put_the_aisles_first_or_last() -> None:
    space = bare_space(PALLET, ("epal1", (0.0, 2.0, 0.072), 0.0), ("epal1", (3.0, -4.0, 0.072), 0.0))
    for aisle_fraction, expected in ((1.0, [True, True, False]), (0.0, [False, True, True])):
        targets = space.shuffled_targets(aisle_fraction, np.random.default_rng(0))
        assert [space.in_aisle(item) for item in targets] == expected


def test_a_scene_says_where_its_aisle_is() -> None:
    scene = aisle_scene(0)
    assert FreeSpace.of_scene(scene).area.y_max == 0.0
    with pytest.raises(PlacementError, match="does not say where its aisle is"):
        FreeSpace.of_scene(replace(scene, aisle=None))
    with pytest.raises(PlacementError, match="no object of the scene is of a target class"):
        FreeSpace.of(scene.instances, scene.models, ("person",), AREA)
