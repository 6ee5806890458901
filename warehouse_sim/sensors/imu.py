"""An inertial measurement unit in the camera: what its axes feel, an offset that a scene keeps, and white noise."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.schema import ChannelReading, Viewpoint
from warehouse_sim.sensors.view import SensorView

GRAVITY = 9.80665
"""Standard acceleration of free fall (m/s^2)."""
_UNITS = {"accel": "m/s^2", "gyro": "rad/s"}
# The BMI055 in Intel's D435i depth camera. Source: Bosch Sensortec, BMI055 data sheet BST-BMI055-DS000-08 (2014),
# typical values, unverified: its table was not at hand; rates of the D435i.
_ACCEL_SIGMA = 1e-6 * GRAVITY * 150.0 * np.sqrt(62.5)
"""Standard deviation of the accelerometer's noise (m/s^2): 150e-6 g/sqrt(Hz), filtered to 62.5 Hz."""
_ACCEL_BIAS = 1e-3 * GRAVITY * 70.0
"""Largest offset of an axis of the accelerometer (m/s^2); drawn evenly, once a scene."""
_GYRO_SIGMA = np.deg2rad(0.014) * np.sqrt(47.0)
"""Standard deviation of the gyroscope's noise (rad/s): 0.014 deg/s/sqrt(Hz), filtered to 47 Hz."""
_GYRO_BIAS = np.deg2rad(1.0)
"""Largest offset of an axis of the gyroscope (rad/s); drawn evenly, once a scene."""


@dataclass(frozen=True)
class Imu:
    """The sensor ``imu``; its axes are those of a camera, x right, y down, z forward, as depth cameras report them."""

    is_camera: ClassVar[bool] = True
    reads_light: ClassVar[bool] = False

    def read(self, view: SensorView, rng: np.random.Generator) -> ChannelReading:
        """Return specific force ``accel`` (m/s^2) and angular velocity ``gyro`` (rad/s), each with three axes.

        At rest and level, ``accel`` is 9.81 m/s^2 upwards, along -y.
        """
        T, scene = view.T_world_sensor, view.scene
        bias_rng = scene_rng(scene.seed, scene.scene_index, "imu bias", scene.attempt)
        accel_bias, gyro_bias = (most * bias_rng.uniform(-1.0, 1.0, 3) for most in (_ACCEL_BIAS, _GYRO_BIAS))
        turning = T[:3, :3].T @ [0.0, 0.0, view.viewpoint.yaw_rate]
        accel = specific_force(T, view.viewpoint) + accel_bias + _ACCEL_SIGMA * rng.standard_normal(3)
        gyro = turning + gyro_bias + _GYRO_SIGMA * rng.standard_normal(3)
        return ChannelReading({"accel": accel, "gyro": gyro}, _UNITS)


def specific_force(T_world_sensor: Transform, viewpoint: Viewpoint) -> Float[np.ndarray, " 3"]:
    """Return acceleration less gravity in the sensor's frame (m/s^2).

    The vehicle drives and turns steadily, as it does for every sensor: with w its yaw rate and r the way from its
    origin, the acceleration is w x v + w x (w x r). What it brakes or speeds up by is left out.

    Args:
        T_world_sensor: Pose of the sensor.
        viewpoint: How what carries it moves.
    """
    turning, lever = np.array([0.0, 0.0, viewpoint.yaw_rate]), T_world_sensor[:3, 3] - viewpoint.T_world_carrier[:3, 3]
    acceleration = np.cross(turning, np.asarray(viewpoint.velocity) + np.cross(turning, lever))
    felt: Float[np.ndarray, " 3"] = T_world_sensor[:3, :3].T @ (acceleration + np.array([0.0, 0.0, GRAVITY]))
    return felt
