"""What a rig states of its calibration is off as rendered: by closed forms, once a scene, each sensor for itself."""

from functools import partial

import numpy as np
import pytest

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import invert, level_camera, make_transform, rotation_angle, rotation_z
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.schema import MountedReading, Observation, RenderBuffers, RgbdReading, Viewpoint
from warehouse_sim.sensors.rig import CalibrationConfig, CalibrationError, Mount, RigConfig

CAMERA = PinholeCamera(640, 480, 500.0, 500.0, 319.5, 239.5)
T_CAMERA_LIDAR = make_transform(np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]]), np.array([0.0, -0.2, -0.3]))


def error(T_sensor_nominal: np.ndarray | None = None, offset: float = 0.0, **more: object) -> CalibrationError:
    T = np.eye(4) if T_sensor_nominal is None else T_sensor_nominal
    settings = {"focal_factor": 1.0, "lens_factor": 1.0, "depth_factor": 1.0, "center_px": (0.0, 0.0)} | more
    return CalibrationError(**settings, T_sensor_nominal={"lidar": T}, time_offset={"lidar": offset})


def seen_from(viewpoint: Viewpoint) -> Observation:
    empty = np.zeros((1, 1), np.float32)
    rgb = np.zeros((1, 1, 3), np.uint8)
    readings = {
        "camera": MountedReading(np.eye(4), RgbdReading(rgb, empty)),
        "lidar": MountedReading(T_CAMERA_LIDAR, RgbdReading(rgb, empty)),
    }
    buffers = RenderBuffers(rgb, empty, np.zeros((1, 1), np.int32))
    return Observation(0, 0, CAMERA, viewpoint.T_world_camera, readings, buffers, ())


def test_the_stated_camera_projects_where_it_should() -> None:
    """At x / z = 0.4, y / z = -0.2: f (1 + s) 0.4 + cx + 3 px."""
    nominal = error(focal_factor=1.01, center_px=(3.0, -2.0)).camera(CAMERA)
    u, v = nominal.project(np.array([2.0, -1.0, 5.0]))
    assert u == pytest.approx(500 * 1.01 * 0.4 + 319.5 + 3.0, abs=1e-9)
    assert v == pytest.approx(-500 * 1.01 * 0.2 + 239.5 - 2.0, abs=1e-9)


def test_a_lens_is_stated_to_displace_more() -> None:
    lens = Distortion(-0.2, 0.05, 0.001, -0.002, 0.003)
    true = PinholeCamera(640, 480, 500.0, 500.0, 319.5, 239.5, lens)
    nominal = error(lens_factor=1.1).camera(true)
    point = np.array([0.5, -0.3, 1.0])
    straight = true.pinhole.project(point)
    np.testing.assert_allclose(nominal.project(point) - straight, 1.1 * (true.project(point) - straight), atol=1e-9)


def test_on_a_straight_drive_a_time_offset_is_a_way_of_velocity_times_time() -> None:
    T_world_camera = level_camera(np.array([2.0, 1.0, 1.5]), 0.7, -0.2)
    for velocity in ((1.4, 0.0, 0.0), (0.6, -1.1, 0.0)):
        view = Viewpoint(T_world_camera, T_world_vehicle=make_transform(), velocity=velocity)
        T_nominal = error(offset=0.03).nominal(seen_from(view), view).T_camera_sensor["lidar"]
        moved = (T_world_camera @ T_nominal)[:3, 3] - (T_world_camera @ T_CAMERA_LIDAR)[:3, 3]
        np.testing.assert_allclose(moved, 0.03 * np.array(velocity), atol=1e-12)
        np.testing.assert_allclose(T_nominal[:3, :3], T_CAMERA_LIDAR[:3, :3], atol=1e-12)


def test_in_a_turn_it_is_the_yaw_of_that_time_and_standing_it_is_nothing() -> None:
    T_world_camera = level_camera(np.array([2.0, 1.0, 1.5]), 0.7)
    turning = Viewpoint(T_world_camera, T_world_vehicle=make_transform(), velocity=(1.0, 0, 0), yaw_rate=0.5)
    T_nominal = error(offset=-0.1).nominal(seen_from(turning), turning).T_camera_sensor["lidar"]
    assert rotation_angle(T_nominal[:3, :3], T_CAMERA_LIDAR[:3, :3]) == pytest.approx(0.05, abs=1e-9)
    standing = Viewpoint(T_world_camera)
    T_nominal = error(offset=-0.1).nominal(seen_from(standing), standing).T_camera_sensor["lidar"]
    assert np.array_equal(T_nominal, T_CAMERA_LIDAR)


def test_the_stated_pose_is_the_true_one_off_by_the_sensors_own_error() -> None:
    T_error = make_transform(level_camera(np.zeros(3), 0.01, 0.02)[:3, :3], np.array([0.01, 0.02, -0.03]))
    view = Viewpoint(level_camera(np.array([0.0, 0, 1]), 0.0))
    T_nominal = error(T_error).nominal(seen_from(view), view).T_camera_sensor["lidar"]
    np.testing.assert_allclose(invert(T_CAMERA_LIDAR) @ T_nominal, T_error, atol=1e-12)


def test_errors_have_the_stated_spread_and_are_never_larger_than_three_of_it() -> None:
    config = CalibrationConfig()
    sampled = [config.sample({"lidar": None}, partial(scene_rng, 0, scene)) for scene in range(4000)]
    found = {
        "focal_fraction": [item.focal_factor - 1 for item in sampled],
        "lens_fraction": [item.lens_factor - 1 for item in sampled],
        "depth_fraction": [item.depth_factor - 1 for item in sampled],
        "center_px": [x for item in sampled for x in item.center_px],
        "place": [x for item in sampled for x in item.T_sensor_nominal["lidar"][:3, 3]],
        "time_ms": [1e3 * item.time_offset["lidar"] for item in sampled],
        # Small turns: the angle about x is the entry (2, 1).
        "angle_deg": [np.degrees(item.T_sensor_nominal["lidar"][2, 1]) for item in sampled],
    }
    for name, values in found.items():
        spread = getattr(config, name)
        # Cutting a normal distribution off at three deviations leaves 0.99 of its spread.
        assert np.std(values) == pytest.approx(spread, rel=0.05), name
        assert np.abs(values).max() <= 3.0001 * spread, name
        assert abs(np.mean(values)) < 0.06 * spread, name


def test_a_sensor_more_changes_no_other_and_the_cameras_housing_is_its_own() -> None:
    stream = partial(scene_rng, 3, 7)
    one = CalibrationConfig().sample({"camera": None, "lidar": None, "imu": None, "right": None}, stream)
    two = CalibrationConfig().sample({"rear": None, "lidar": None}, stream)
    assert list(one.T_sensor_nominal) == ["lidar"]
    assert np.array_equal(one.T_sensor_nominal["lidar"], two.T_sensor_nominal["lidar"])
    assert not np.array_equal(two.T_sensor_nominal["rear"], two.T_sensor_nominal["lidar"])
    assert (one.focal_factor, one.center_px, one.time_offset["lidar"]) == (
        two.focal_factor, two.center_px, two.time_offset["lidar"],
    )  # fmt: skip
    assert two.time_offset["rear"] != two.time_offset["lidar"]


def test_it_is_off_by_default_and_comes_back_from_plain_data() -> None:
    assert RigConfig().calibration is None
    assert "calibration" not in to_mapping(RigConfig())
    rig = from_mapping(RigConfig, {"calibration": {"place": 0.02}}, "here")
    assert rig.calibration == CalibrationConfig(place=0.02)
    assert from_mapping(RigConfig, to_mapping(rig), "here") == rig


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
