from dataclasses import replace

import numpy as np
import pytest

from tests.scene.viewpoints.spaces import AREA, aisle_scene, bare_space
from warehouse_sim.catalog import catalog_object
from warehouse_sim.config import to_mapping
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import level_camera, transform_points
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene import SceneRecipe, sample_scene
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import (
    angles_to,
    is_framed,
    is_off_axis,
    shows,
    target_in_view,
    targets_in_frame,
)
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import AMR, FORKLIFT, MOUNTINGS, pose_on_floor
from warehouse_sim.schema import Viewpoint

PRIORS = {
    "forklift_mast": (1.8, 2.2, -25.0, -10.0),
    "forklift_forks": (0.25, 0.55, -5.0, 5.0),
    "forklift_guard": (2.1, 2.4, -20.0, -5.0),
    "amr": (0.3, 1.0, -5.0, 5.0),
    "level": (0.4, 3.5, 0.0, 0.0),
    "post": (0.3, 3.5, -30.0, 5.0),
    "ceiling": (4.0, 8.0, -90.0, -40.0),
}


@pytest.mark.parametrize("kind", MOUNTINGS)
def test_heights_and_pitches_are_the_documented_ones(kind: str) -> None:
    mounting = MOUNTINGS[kind]
    found = (mounting.height.low, mounting.height.high, mounting.pitch_deg.low, mounting.pitch_deg.high)
    assert found == pytest.approx(PRIORS[kind])
    assert mounting.vehicle is None or mounting.vehicle.rear < mounting.forward <= mounting.tip


def test_a_camera_sits_ahead_of_the_vehicles_origin_and_looks_down_by_its_pitch() -> None:
    mounting = MOUNTINGS["forklift_forks"]
    T = mounting.camera(pose_on_floor(1.0, 2.0, 0.5), 0.4, np.deg2rad(-10.0))
    np.testing.assert_allclose(T[:3, 3], [1 + mounting.forward * np.cos(0.5), 2 + mounting.forward * np.sin(0.5), 0.4])
    flat = np.cos(np.deg2rad(10.0))
    np.testing.assert_allclose(T[:3, 2], [flat * np.cos(0.5), flat * np.sin(0.5), -np.sin(np.deg2rad(10.0))])
    assert T[2, 0] == pytest.approx(0.0, abs=1e-12)  # no roll


def test_the_fork_camera_is_just_behind_the_tips_and_only_mast_and_forks_go_up() -> None:
    assert 0.1 < FORKLIFT.tip - MOUNTINGS["forklift_forks"].forward < 0.3
    assert [kind for kind, mounting in MOUNTINGS.items() if mounting.lifts] == ["forklift_mast", "forklift_forks"]


def test_the_trucks_outline_is_the_catalogs() -> None:
    length, width, height = catalog_object("forklift").size
    assert FORKLIFT.tip - FORKLIFT.rear == pytest.approx(length, abs=1e-3)
    assert pytest.approx(width, abs=1e-3) == FORKLIFT.width
    assert pytest.approx(height, abs=1e-3) == FORKLIFT.height


@pytest.mark.parametrize("yaw", [0.0, 0.8])
def test_boxes_reach_from_rear_to_fork_tips_in_the_vehicles_frame(yaw: float) -> None:
    boxes = FORKLIFT.boxes(pose_on_floor(2.0, 1.0, yaw), lift=1.0)
    ahead = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    along = np.array([(box.corners() - [2.0, 1.0, 0.0]) @ ahead for box in boxes])
    assert along.min() == pytest.approx(FORKLIFT.rear)
    assert along.max() == pytest.approx(FORKLIFT.tip)
    assert boxes[1].corners()[:, 2].max() == pytest.approx(1.15)  # the blades go up, the body stays
    assert boxes[0].corners()[:, 2].max() == pytest.approx(FORKLIFT.height)


def test_a_robot_without_forks_is_one_box_above_what_lies_flat() -> None:
    (low,), (high,) = BoxStack.of(AMR.boxes(pose_on_floor(0.0, 0.0, 0.0))).extents()
    np.testing.assert_allclose(high[:2] - low[:2], [0.96, 0.65])
    assert 0.05 < low[2] < 0.1
    assert AMR.tip == AMR.front


def test_the_kind_can_be_left_open_and_each_scene_has_one() -> None:
    plain = {
        "layout": {"bays": 2, "beam_levels": [1.45]},
        "viewpoints": {"kind": {"choices": ["amr", "free", "level"]}},
        "observations_per_scene": 2,
    }
    recipe = SceneRecipe.from_plain(plain, "here")
    assert SceneRecipe.from_plain(to_mapping(recipe), "here") == recipe
    kinds = [{view.kind for view in sample_scene(recipe, 0, index).viewpoints} for index in range(7)]
    assert all(len(kind) == 1 for kind in kinds)
    assert set.union(*kinds) == {"amr", "free", "level"}


def test_a_recipe_can_ask_for_level_sequences() -> None:
    plain = {
        "layout": {"bays": 3, "beam_levels": [1.45]},
        "staging": {"count": 0},
        "viewpoints": {"kind": "forklift_forks", "trajectory": "approach", "level": True, "drive": {"drives": 2}},
        "observations_per_scene": 7,
    }
    views = sample_scene(SceneRecipe.from_plain(plain, "here"), 0, 0).viewpoints
    assert [view.sequence for view in views] == [0] * 4 + [1] * 3
    assert all(abs(view.T_world_camera[2, 2]) < 1e-12 for view in views)


CONFIG = ViewpointsConfig()
NEAR, FAR = ("epal1", (3.0, -4.0, 0.072), 0.0), ("epal1", (6.0, -3.0, 0.072), 0.0)
VIEW = Viewpoint(level_camera(np.array([0.0, -4.0, 0.5]), 0.0))


def test_angles_are_those_beside_and_above_the_axis() -> None:
    bearing, elevation = angles_to(
        level_camera(np.array([0.0, 0.0, 1.0]), 0.0, np.deg2rad(-20.0)), np.array([[2.0, 2.0, 1.0], [2.0, 0.0, 1.0]])
    )
    assert elevation[1] == pytest.approx(np.deg2rad(20.0))
    assert bearing[1] == pytest.approx(0.0)
    # Tilting the camera by 20 degrees shortens the depth of a point at 45 degrees.
    assert bearing[0] == pytest.approx(np.arctan2(1.0, np.cos(np.deg2rad(20.0))))


def test_a_quick_look_rejects_what_the_exact_one_rejects() -> None:
    rng, framed = np.random.default_rng(0), []
    for _ in range(500):
        place, point = rng.uniform(-3.0, 3.0, (2, 3))
        yaw, pitch, roll = rng.uniform([-np.pi, -1.5, -0.2], [np.pi, 1.0, 0.2])
        config = replace(CONFIG, max_elevation_deg=float(rng.uniform(1, 45)), max_bearing_deg=float(rng.uniform(1, 80)))
        framed.append(is_framed(level_camera(place, yaw, pitch, roll), point, config))
        assert is_off_axis(point.tolist(), place.tolist(), (yaw, pitch, roll), config) != framed[-1]
    assert 20 < sum(framed) < 480


def test_targets_in_frame_come_by_distance_and_the_edge_counts() -> None:
    space = bare_space(FAR, NEAR, ("epal1", (-3.0, -4.0, 0.072), 0.0), ("epal1", (2.0, -7.0, 0.072), 0.0))
    assert [item.instance_id for item in targets_in_frame(VIEW.T_world_camera, space, CONFIG)] == [3, 2]
    narrow = replace(CONFIG, max_bearing_deg=5.0)
    assert [item.instance_id for item in targets_in_frame(VIEW.T_world_camera, space, narrow)] == [3]


def test_as_many_targets_as_requested_must_be_in_sight() -> None:
    space = bare_space(NEAR, FAR)
    near = space.targets[0]
    assert shows(VIEW, near, space, replace(CONFIG, min_targets=2))
    assert not shows(VIEW, near, space, replace(CONFIG, min_targets=3))
    hidden = bare_space(NEAR, FAR, *(("carton_600x400x400", (5.0, -3.35, z), np.pi / 2) for z in (0.2, 0.6)))
    assert shows(VIEW, hidden.targets[0], hidden, CONFIG)
    assert not shows(VIEW, hidden.targets[0], hidden, replace(CONFIG, min_targets=2))
    assert not shows(VIEW, hidden.targets[1], hidden, CONFIG)


def test_the_aim_counts_while_it_is_in_view_and_the_nearest_otherwise() -> None:
    space = bare_space(NEAR, FAR)
    near, far = space.targets
    assert target_in_view(VIEW, space, CONFIG) is near
    assert target_in_view(VIEW, space, CONFIG, aim=far) is far
    assert target_in_view(VIEW, space, replace(CONFIG, max_bearing_deg=5.0), aim=far) is near
    back = Viewpoint(level_camera(np.array([0.0, -4.0, 0.5]), np.pi))
    assert target_in_view(back, space, CONFIG, aim=far) is None


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
