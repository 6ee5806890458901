import numpy as np
import pytest

from warehouse_sim.scene.viewpoints.drives import Drive, Mount
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS
from warehouse_sim.scene.viewpoints.paths import Arc, FloorPose, Path, SpeedProfile
from warehouse_sim.schema import Viewpoint

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
