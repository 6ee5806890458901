import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene.viewpoints.drives import Arc, Drive, FloorPose, Mount, Path, SpeedProfile
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
