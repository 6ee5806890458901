"""The inertial unit against closed forms: gravity in its axes, centripetal force, bounds of bias, size of noise."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.pose import invert, level_camera, make_transform, rotation_z
from warehouse_sim.schema import ChannelReading, SceneSpec, Viewpoint
from warehouse_sim.sensors.imu import Imu, specific_force
from warehouse_sim.sensors.motion import EgoMotion
from warehouse_sim.sensors.rig import RigConfig

G = 9.80665
STILL = Viewpoint(level_camera(np.array([1.0, 2.0, 1.5]), 0.7))
PITCH, ROLL = np.deg2rad(-25.0), np.deg2rad(3.0)
TILTED = Viewpoint(level_camera(np.array([1.0, 2.0, 1.5]), 0.7, PITCH, ROLL))


class Moment:
    """What an inertial unit asks of a view."""

    def __init__(self, viewpoint: Viewpoint, scene_index: int = 0) -> None:
        self.viewpoint, self.T_world_sensor = viewpoint, viewpoint.T_world_camera
        self.scene = SceneSpec(scene_index, 0, {}, {}, (), (), ())


class NoNoise:
    """A random stream of zeros."""

    standard_normal = staticmethod(np.zeros)


def readings(viewpoint: Viewpoint, scenes: int, each: int, quiet: bool = False) -> dict[str, np.ndarray]:
    """Return what is read in several scenes, (scene, reading, axis) by channel."""
    rng: Any = NoNoise() if quiet else np.random.default_rng(0)

    def read(index: int) -> ChannelReading:
        return Imu().read(Moment(viewpoint, index), rng)

    found = [[read(index).channels for _ in range(each)] for index in range(scenes)]
    return {name: np.array([[item[name] for item in row] for row in found]) for name in ("accel", "gyro")}


def test_the_mean_over_many_scenes_is_gravity_in_the_axes_of_the_tilted_camera() -> None:
    found = readings(TILTED, 4000, 1)
    # A camera that looks down by p and is turned by r about its axis has the world's up at
    # (-cos p sin r, -cos p cos r, sin p): looking straight down it is -z, level it is -y.
    up = np.array([-np.cos(PITCH) * np.sin(ROLL), -np.cos(PITCH) * np.cos(ROLL), np.sin(PITCH)])
    error = 4.0 * 0.07 * G / np.sqrt(3.0 * 4000)
    np.testing.assert_allclose(found["accel"].mean(axis=(0, 1)), G * up, atol=error)
    np.testing.assert_allclose(found["gyro"].mean(axis=(0, 1)), 0.0, atol=4.0 * np.deg2rad(1.0) / np.sqrt(3.0 * 4000))


def test_a_level_camera_at_rest_feels_the_floor_push_upwards() -> None:
    np.testing.assert_allclose(specific_force(STILL.T_world_camera, STILL), [0.0, -G, 0.0], atol=1e-12)


def test_the_bias_stays_within_the_data_sheet_and_is_kept_through_a_scene() -> None:
    found = readings(STILL, 2000, 2, quiet=True)
    for name, limit, gt in (("accel", 0.07 * G, [0.0, -G, 0.0]), ("gyro", np.deg2rad(1.0), [0.0, 0.0, 0.0])):
        bias = found[name] - gt
        np.testing.assert_array_equal(bias[:, 0], bias[:, 1])
        assert np.abs(bias).max() <= limit + 1e-12
        assert np.abs(bias).max() > 0.99 * limit
        assert np.abs(np.corrcoef(bias[:, 0].T) - np.eye(3)).max() < 0.08


def test_the_noise_is_density_times_the_root_of_the_bandwidth() -> None:
    found = readings(STILL, 1, 5_000)
    for name, sigma in (
        ("accel", 150e-6 * G * np.sqrt(62.5)),
        ("gyro", np.deg2rad(0.014) * np.sqrt(47.0)),  # 0.1 deg/s rms, as the data sheet says of 47 Hz
    ):
        np.testing.assert_allclose(found[name].std(axis=(0, 1)), sigma, rtol=0.03)
    assert np.rad2deg(found["gyro"][0].std(axis=0)) == pytest.approx([0.096] * 3, abs=0.006)


def test_in_a_turn_it_feels_what_the_path_bends_by() -> None:
    T_world_vehicle = make_transform(rotation_z(0.4), np.array([2.0, 1.0, 0.0]))
    T_world_camera = level_camera(np.array([2.8, 1.9, 1.2]), 0.4, -0.3, 0.02)
    view = Viewpoint(T_world_camera, T_world_vehicle=T_world_vehicle, velocity=(1.2, 0.5, 0.0), yaw_rate=0.6)
    motion, step = EgoMotion.of(view), 0.05
    assert motion is not None
    place = np.tile(T_world_camera[:3, 3], (3, 1))
    places = motion.carried(place, place, np.array([-step, 0.0, step]))[0].astype(float)
    bend = (places[0] - 2 * places[1] + places[2]) / step**2  # single precision: to some 1e-3 m/s^2
    expected = invert(T_world_camera)[:3, :3] @ (bend + np.array([0.0, 0.0, G]))
    np.testing.assert_allclose(specific_force(T_world_camera, view), expected, atol=2e-3)
    assert np.linalg.norm(bend) > 0.5
    turning, still = (readings(item, 1, 1, quiet=True)["gyro"][0, 0] for item in (view, STILL))  # of one bias
    np.testing.assert_allclose(T_world_camera[:3, :3] @ (turning - still), [0.0, 0.0, 0.6], atol=1e-12)


def test_it_belongs_to_every_rig_unless_switched_off_and_takes_no_other_sensors_name() -> None:
    rig = RigConfig()
    assert list(rig.mounted()) == ["camera", "lidar", "imu"]
    assert "imu" not in replace(rig, imu=None).mounted()
    assert RigConfig.from_plain(to_mapping(replace(rig, imu=None)), "here").imu is None
    assert from_mapping(RigConfig, {"imu": {}}, "here") == rig
    with pytest.raises(ConfigError, match="every sensor of a rig needs a name of its own; imu"):
        from_mapping(RigConfig, {"more": {"imu": {"sensor": "imu"}}}, "here")
