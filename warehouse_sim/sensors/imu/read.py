"""One reading of an inertial measurement unit: what its axes feel, an offset that a scene keeps, and white noise."""

from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

import numpy as np
from jaxtyping import Float

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.schema import ChannelReading, Viewpoint
from warehouse_sim.sensors.view import SensorView


@dataclass(frozen=True)
@ranged
class ImuConfig:
    """Bias and noise of a consumer MEMS unit; the defaults are those of the BMI055 in Intel's D435i depth camera.

    Source: Bosch Sensortec, BMI055 data sheet BST-BMI055-DS000-08 (2014), typical values, unverified: its table was
    not at hand; rates of the D435i.
    """

    accel_noise_ug: Annotated[float, Range(0, 100_000, "ug/sqrt(Hz)")] = 150.0
    """Noise density of the accelerometer (1e-6 g/sqrt(Hz)), 0-100,000."""
    accel_bandwidth: Annotated[float, Range(0.1, 10_000, "Hz")] = 62.5
    """Bandwidth that its readings are filtered to (Hz), 0.1-10,000."""
    accel_bias_mg: Annotated[float, Range(0, 1000, "mg")] = 70.0
    """Largest offset of an axis of the accelerometer (1e-3 g), 0-1,000; drawn evenly, once a scene."""
    gyro_noise_deg: Annotated[float, Range(0, 100, "deg/s/sqrt(Hz)")] = 0.014
    """Noise density of the gyroscope (deg/s/sqrt(Hz)), 0-100."""
    gyro_bandwidth: Annotated[float, Range(0.1, 10_000, "Hz")] = 47.0
    """Bandwidth that its readings are filtered to (Hz), 0.1-10,000."""
    gyro_bias_deg: Annotated[float, Range(0, 100, "deg/s")] = 1.0
    """Largest offset of an axis of the gyroscope (deg/s), 0-100; drawn evenly, once a scene."""


GRAVITY = 9.80665
"""Standard acceleration of free fall (m/s^2)."""
_UNITS = {"accel": "m/s^2", "gyro": "rad/s"}


@dataclass(frozen=True)
class Imu:
    """The sensor ``imu``; its axes are those of a camera, x right, y down, z forward, as depth cameras report them."""

    is_camera: ClassVar[bool] = True
    reads_light: ClassVar[bool] = False

    config: ImuConfig = field(default_factory=ImuConfig)
    """Bias and noise."""

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "Imu":
        """Read the settings of its errors.

        Raises:
            ConfigError: Unknown setting.
        """
        return cls(from_mapping(ImuConfig, data, where))

    def to_plain(self) -> dict[str, Any]:
        """Return what ``from_plain`` reads back."""
        plain: dict[str, Any] = to_mapping(self.config)
        return plain

    def read(self, view: SensorView, rng: np.random.Generator) -> ChannelReading:
        """Return specific force ``accel`` (m/s^2) and angular velocity ``gyro`` (rad/s), each with three axes.

        At rest and level, ``accel`` is 9.81 m/s^2 upwards, along -y.
        """
        config, T, scene = self.config, view.T_world_sensor, view.scene
        bias_rng = scene_rng(scene.seed, scene.scene_index, "imu bias", scene.attempt)
        accel_bias = 1e-3 * GRAVITY * config.accel_bias_mg * bias_rng.uniform(-1.0, 1.0, 3)
        gyro_bias = np.deg2rad(config.gyro_bias_deg) * bias_rng.uniform(-1.0, 1.0, 3)
        accel_sigma = 1e-6 * GRAVITY * config.accel_noise_ug * np.sqrt(config.accel_bandwidth)
        gyro_sigma = np.deg2rad(config.gyro_noise_deg) * np.sqrt(config.gyro_bandwidth)
        turning = T[:3, :3].T @ [0.0, 0.0, view.viewpoint.yaw_rate]
        accel = specific_force(T, view.viewpoint) + accel_bias + accel_sigma * rng.standard_normal(3)
        gyro = turning + gyro_bias + gyro_sigma * rng.standard_normal(3)
        return ChannelReading({"accel": accel, "gyro": gyro}, _UNITS)


def specific_force(T_world_sensor: Transform, viewpoint: Viewpoint) -> Float[np.ndarray, " 3"]:
    """Return acceleration less gravity in the sensor's frame (m/s^2).

    The vehicle drives and turns steadily, as it does for every sensor: with w its yaw rate and r the way from its
    origin, the acceleration is w x v + w x (w x r). What it brakes or speeds up by is left out.

    Args:
        T_world_sensor: Pose of the sensor.
        viewpoint: How what carries it moves.
    """
    T_carrier = viewpoint.T_world_camera if viewpoint.T_world_vehicle is None else viewpoint.T_world_vehicle
    turning, lever = np.array([0.0, 0.0, viewpoint.yaw_rate]), T_world_sensor[:3, 3] - T_carrier[:3, 3]
    acceleration = np.cross(turning, np.asarray(viewpoint.velocity) + np.cross(turning, lever))
    felt: Float[np.ndarray, " 3"] = T_world_sensor[:3, :3].T @ (acceleration + np.array([0.0, 0.0, GRAVITY]))
    return felt
