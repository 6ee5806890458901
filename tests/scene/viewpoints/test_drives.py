from functools import cache

import numpy as np
import pytest

from tests.scene.viewpoints.spaces import aisle_scene, bare_space
from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.pose import invert, make_transform, rotation_z
from warehouse_sim.scene.viewpoints.choose import choose_drives
from warehouse_sim.scene.viewpoints.config import DriveConfig, ViewpointsConfig
from warehouse_sim.scene.viewpoints.drives import Arc, Drive, FloorPose, Mount, Path, SpeedProfile
from warehouse_sim.scene.viewpoints.framing import shows
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS
from warehouse_sim.scene.viewpoints.plans import entries_of, pose_before
from warehouse_sim.schema import ObjectInstance, Viewpoint

PATHS = {
    "straight": (Arc(6.0),),
    "left": (Arc(2.0), Arc(0.75 * np.pi, 1 / 1.5), Arc(1.0)),
    "right": (Arc(1.0), Arc(np.pi, -0.5), Arc(0.4)),
}


def make_drive(name: str, rolling: bool) -> Drive:
    path = Path(FloorPose(1.0, -3.0, 0.4), PATHS[name])
    mount = Mount("forklift_mast", MOUNTINGS["forklift_mast"], 2.0, np.deg2rad(-15.0), 0.0)
    return Drive(mount, path, SpeedProfile.over(path.length, 1.2, 0.6, rolling))


def place_of(view: Viewpoint) -> np.ndarray:
    return view.T_world_vehicle[:3, 3]


def heading_of(view: Viewpoint) -> float:
    return float(np.arctan2(view.T_world_vehicle[1, 0], view.T_world_vehicle[0, 0]))


@pytest.mark.parametrize("rolling", [False, True])
@pytest.mark.parametrize("name", PATHS)
def test_velocity_and_yaw_rate_are_the_derivatives_of_the_pose(name: str, rolling: bool) -> None:
    drive, step = make_drive(name, rolling), 1e-4
    # Times away from the few instants at which the wheels are turned or the brake is set at once.
    for time in np.linspace(0.05, 0.97, 53) * drive.duration:
        before, view, after = (drive.at(time + shift) for shift in (-step, 0.0, step))
        velocity = (place_of(after) - place_of(before)) / (2 * step)
        np.testing.assert_allclose(view.velocity, velocity, atol=0.01 * np.linalg.norm(velocity))
        turned = np.angle(np.exp(1j * (heading_of(after) - heading_of(before)))) / (2 * step)
        assert view.yaw_rate == pytest.approx(turned, rel=0.01, abs=1e-6)
        sideways = np.array([-np.sin(heading_of(view)), np.cos(heading_of(view)), 0.0])
        assert np.dot(view.velocity, sideways) == pytest.approx(0.0, abs=1e-12)  # the axle does not slip


def test_a_drive_is_at_rest_at_its_end_and_its_camera_rides_along() -> None:
    drive = make_drive("left", rolling=False)
    for time in (0.0, 1.3, drive.duration):
        view = drive.at(time)
        assert view.time == time
        ahead = view.T_world_camera[:3, 3] - place_of(view)
        turn = heading_of(view)
        np.testing.assert_allclose(ahead, [0.42 * np.cos(turn), 0.42 * np.sin(turn), 2.0], atol=1e-12)
    assert drive.at(drive.duration).velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


CORNER = (Arc(3.0), Arc(1.5 * np.pi / 2, 1 / 1.5), Arc(0.5))


def test_a_quarter_circle_to_the_left_ends_where_geometry_says() -> None:
    end, curvature = Path(FloorPose(1.0, 2.0, 0.0), CORNER).at(3.0 + 0.75 * np.pi + 0.5)
    np.testing.assert_allclose([end.x, end.y, end.yaw], [1.0 + 3.0 + 1.5, 2.0 + 1.5 + 0.5, np.pi / 2], atol=1e-12)
    assert curvature == 0.0


@pytest.mark.parametrize("curvature", [-0.7, 0.0, 1e-12, 0.4])
def test_going_back_undoes_going_ahead(curvature: float) -> None:
    there = FloorPose(0.3, -2.0, 1.1).after(1.7, curvature)
    back = there.after(-1.7, curvature)
    np.testing.assert_allclose([back.x, back.y, back.yaw], [0.3, -2.0, 1.1], atol=1e-9)


def test_a_path_made_from_its_end_ends_there() -> None:
    end = FloorPose(-1.0, 4.0, 2.0)
    path = Path.ending_at(end, CORNER)
    reached, _ = path.at(path.length)
    np.testing.assert_allclose([reached.x, reached.y, reached.yaw], [-1.0, 4.0, 2.0], atol=1e-12)


def test_a_part_of_a_path_follows_the_whole() -> None:
    whole = Path(FloorPose(0.0, 0.0, 0.3), CORNER)
    part = whole.part(1.2, 4.9)
    assert part.length == pytest.approx(3.7, abs=1e-12)
    for distance in np.linspace(0.0, 3.7, 9):
        a, b = part.at(distance)[0], whole.at(1.2 + distance)[0]
        np.testing.assert_allclose([a.x, a.y, a.yaw], [b.x, b.y, b.yaw], atol=1e-12)


@pytest.mark.parametrize("rolling", [False, True])
@pytest.mark.parametrize(("length", "speed"), [(10.0, 1.5), (1.0, 6.0), (4.5, 1.5)])
def test_a_profile_covers_its_length_and_ends_at_rest(rolling: bool, length: float, speed: float) -> None:
    profile = SpeedProfile.over(length, speed, 0.5, rolling)
    assert profile.at(0.0)[0] == 0.0
    assert profile.at(0.0)[1] == (profile.peak if rolling else 0.0)
    distance, last = profile.at(profile.duration)
    assert distance == pytest.approx(length, abs=1e-9)
    assert last == pytest.approx(0.0, abs=1e-9)
    times = np.linspace(0.0, profile.duration, 4001)
    distances, speeds = np.array([profile.at(time) for time in times]).T
    assert speeds.max() <= min(speed, profile.peak) + 1e-12
    assert np.abs(np.diff(speeds) / np.diff(times)).max() <= 0.5 + 1e-6
    np.testing.assert_allclose(np.diff(distances) / np.diff(times), (speeds[1:] + speeds[:-1]) / 2, atol=1e-3)


def test_a_long_path_reaches_the_wanted_speed_and_a_short_one_does_not() -> None:
    assert SpeedProfile.over(10.0, 1.5, 0.5).peak == 1.5
    assert SpeedProfile.over(1.0, 1.5, 0.5).peak == pytest.approx(np.sqrt(0.5))
    assert SpeedProfile.over(1.0, 1.5, 0.5, rolling=True).peak == pytest.approx(1.0)


@pytest.mark.parametrize("name", ["epal1", "carton_600x400x400"])
def test_a_pallet_and_a_carton_are_entered_from_the_middle_of_each_side(name: str) -> None:
    model, turn = catalog_object(name), 0.3
    item = ObjectInstance(1, name, make_transform(rotation_z(turn), np.array([1.0, 2.0, 0.072])))
    entries = entries_of(item, model)
    assert len(entries) == 4
    for entry in entries:
        edge = model.size[0] if abs(np.cos(entry.yaw - turn)) > 0.5 else model.size[1]
        into = np.array([np.cos(entry.yaw), np.sin(entry.yaw)])
        np.testing.assert_allclose(np.array([entry.x, entry.y]) + into * edge / 2, [1.0, 2.0], atol=1e-9)
    assert {round(np.rad2deg(entry.yaw - turn)) % 360 for entry in entries} == {0, 90, 180, 270}


def test_a_pose_before_an_entry_is_on_its_line() -> None:
    entry = FloorPose(0.0, 0.0, np.pi / 2)
    straight = pose_before(entry, 2.0, 0.1, 0.0)
    np.testing.assert_allclose([straight.x, straight.y, straight.yaw], [-0.1, -2.0, np.pi / 2], atol=1e-12)
    askew = pose_before(entry, 2.0, 0.0, 0.1)
    reached = askew.after(2.0, 0.0)
    np.testing.assert_allclose([reached.x, reached.y, reached.yaw], [0.0, 0.0, np.pi / 2 + 0.1], atol=1e-12)


TRAJECTORIES = ("drive", "turn_in", "approach")
VEHICLES = ("forklift_mast", "forklift_forks", "forklift_guard", "amr", "level")


@cache
def frames(
    trajectory: str, kind: str = "forklift_forks", count: int = 41, index: int = 0, **settings: object
) -> tuple[tuple[Viewpoint, ...], FreeSpace, ViewpointsConfig]:
    space = FreeSpace.of_scene(aisle_scene(index, staged=1))
    config = ViewpointsConfig(kind=kind, trajectory=trajectory, max_elevation_deg=13.0, **settings)
    return choose_drives(space, count, config, MOUNTINGS[kind], np.random.default_rng(index)), space, config


def flat(view: Viewpoint) -> tuple[np.ndarray, float]:
    T = view.T_world_vehicle
    return T[:2, 3], float(np.arctan2(T[1, 0], T[0, 0]))


@pytest.mark.parametrize("trajectory", TRAJECTORIES)
def test_a_sequence_is_even_in_time_and_begins_at_zero(trajectory: str) -> None:
    views, _, _ = frames(trajectory)
    times = [view.time for view in views]
    assert times[0] == 0.0
    np.testing.assert_allclose(np.diff(times), times[1])
    assert {view.sequence for view in views} == {0}
    assert {view.kind for view in views} == {"forklift_forks"}


@pytest.mark.parametrize("kind", VEHICLES)
@pytest.mark.parametrize("trajectory", TRAJECTORIES)
def test_every_frame_shows_its_target_and_has_room(trajectory: str, kind: str) -> None:
    views, space, config = frames(trajectory, kind, count=15, index=1)
    vehicle = MOUNTINGS[kind].vehicle
    for view in views:
        target = next(item for item in space.targets if item.instance_id == view.target)
        assert shows(view, target, space, config)
        distance = space.solids.boxes.distances_to(view.T_world_camera[:3, 3])
        assert distance[space.solids.owner != 1].min() >= 0.7
        if vehicle is not None:
            assert space.admits_bodies(vehicle.boxes(view.T_world_vehicle)[:1])


def test_a_turn_in_turns_by_a_right_angle_and_ends_before_its_target() -> None:
    views, space, _ = frames("turn_in")
    (_, first), (_, last) = flat(views[0]), flat(views[-1])
    assert np.abs(np.angle(np.exp(1j * (last - first)))) == pytest.approx(np.pi / 2, abs=1e-9)
    rates = np.array([view.yaw_rate for view in views])
    assert (rates == 0.0).any()
    assert (rates != 0.0).sum() >= 5
    target = next(item for item in space.targets if item.instance_id == views[-1].target)
    assert not space.in_aisle(target)
    assert abs(np.sin(first)) < np.sin(np.deg2rad(8.0))  # along the aisle, but for the load's and the driver's error


def test_an_approach_is_straight_slows_down_and_stops_before_the_pockets() -> None:
    views, space, _ = frames("approach", index=1)
    speeds = np.array([np.hypot(*view.velocity[:2]) for view in views])
    assert speeds[-1] == pytest.approx(0.0, abs=1e-9)
    assert (np.diff(speeds) <= 1e-9).all()
    assert 0.3 <= speeds[0] <= 0.8
    target = next(item for item in space.targets if item.instance_id == views[0].target)
    tip = MOUNTINGS["forklift_forks"].tip
    gaps = []
    for view in views:
        local = [
            (invert(view.T_world_vehicle) @ np.array([entry.x, entry.y, 0.0, 1.0]))[:2]
            for entry in entries_of(target, space.models[target.model])
        ]
        ahead, aside = min(local, key=np.linalg.norm)
        gaps.append(ahead - tip)
        assert abs(aside) < 0.15 + ahead * np.sin(np.deg2rad(5.0))
    assert 0.75 <= gaps[-1] <= 1.0
    assert 4.5 <= gaps[0] <= 6.0


def test_observations_are_shared_out_among_drives() -> None:
    views, _, _ = frames("drive", count=11, drive=DriveConfig(drives=3))
    assert [view.sequence for view in views] == [0] * 4 + [1] * 4 + [2] * 3
    assert [view.time for view in views].count(0.0) == 3


def test_views_on_their_own_are_moments_of_different_drives() -> None:
    views, _, _ = frames("approach", count=6, drive=DriveConfig(sequence=False))
    assert {view.sequence for view in views} == {None}
    assert {view.time for view in views} == {0.0}
    assert len({view.T_world_vehicle[:2, :2].tobytes() for view in views}) == 6
    assert max(np.hypot(*view.velocity[:2]) for view in views) > 0.1


def test_a_drive_that_finds_no_room_says_what_to_widen() -> None:
    walls = [("carton_600x400x400", (x, y, 0.2), 0.0) for x in (-2.5, 2.5) for y in (-7.0, -5.0, -4.0, -3.0, -1.0)]
    space = bare_space(("epal1", (0.0, -4.0, 0.072), 0.0), *walls)
    config = ViewpointsConfig(kind="forklift_mast", trajectory="approach", max_elevation_deg=2.0)
    with pytest.raises(PlacementError, match=r"no approach of kind forklift_mast found in 40 tries .* widen layout"):
        choose_drives(space, 3, config, MOUNTINGS["forklift_mast"], np.random.default_rng(0))
