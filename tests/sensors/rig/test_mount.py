import numpy as np
import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z
from warehouse_sim.schema import Viewpoint
from warehouse_sim.sensors.rig import Mount

FORWARD, LEFT, UP = np.array([0.0, 0.0, 1.0]), np.array([-1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])
"""Of a camera, in its own frame."""
DIAGONAL = np.sqrt(0.5)


@pytest.mark.parametrize(
    ("angle", "axis", "expected"),
    [
        ("yaw_deg", 0, DIAGONAL * (FORWARD + LEFT)),
        ("pitch_deg", 0, DIAGONAL * (FORWARD + UP)),
        ("roll_deg", 1, DIAGONAL * (LEFT + UP)),
    ],
)
def test_positive_angles_look_left_look_up_and_lower_the_right_side(
    angle: str, axis: int, expected: np.ndarray
) -> None:
    T = Mount(**{angle: 45.0}).T_camera_sensor()
    np.testing.assert_allclose(T[:3, axis], expected, atol=1e-12)


def test_what_sits_on_the_vehicle_does_not_tilt_or_lift_with_the_camera() -> None:
    T_world_vehicle = make_transform(rotation_z(0.7), np.array([3.0, -2.0, 0.0]))
    mount = Mount(carrier="vehicle", forward=0.4, left=0.1, up=2.2, yaw_deg=30.0)
    for height, pitch in ((0.5, 0.0), (3.1, -0.3)):
        T_world_camera = level_camera(np.array([3.2, -1.9, height]), 0.7, pitch)
        viewpoint = Viewpoint(T_world_camera, T_world_vehicle=T_world_vehicle)
        T_world_sensor = T_world_camera @ mount.T_camera_sensor(viewpoint)
        expected = T_world_vehicle @ make_transform(rotation_z(np.deg2rad(30.0)), np.array([0.4, 0.1, 2.2]))
        np.testing.assert_allclose(T_world_sensor, expected, atol=1e-12)


def test_a_camera_that_nothing_carries_has_no_vehicle() -> None:
    with pytest.raises(ConfigError, match="mounted on the vehicle, but no vehicle carries this camera"):
        Mount(carrier="vehicle").T_camera_sensor(Viewpoint(np.eye(4)))


@pytest.mark.parametrize(("pitch_deg", "roll_deg"), [(0.0, 0.0), (-25.0, 3.0), (-89.0, 0.0)])
def test_an_upright_sensor_stays_so_however_the_camera_tilts(pitch_deg: float, roll_deg: float) -> None:
    T_world_camera = level_camera(np.array([1.0, 2.0, 3.0]), 0.5, np.deg2rad(pitch_deg), np.deg2rad(roll_deg))
    mount = Mount("upright", forward=-0.27, left=0.1, up=0.08)
    T = T_world_camera @ mount.T_camera_sensor(Viewpoint(T_world_camera))
    ahead, left, up = np.array([np.cos(0.5), np.sin(0.5), 0]), np.array([-np.sin(0.5), np.cos(0.5), 0]), np.eye(3)[2]
    np.testing.assert_allclose(T[:3, :3], np.stack([ahead, left, up], axis=1), atol=1e-9)
    np.testing.assert_allclose(T[:3, 3], [1, 2, 3] - 0.27 * ahead + 0.1 * left + 0.08 * up, atol=1e-9)
