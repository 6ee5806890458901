"""An inertial measurement unit in the camera: specific force and angular velocity, with bias and noise."""

from warehouse_sim.sensors.imu.read import Imu, ImuConfig, specific_force

__all__ = ["Imu", "ImuConfig", "specific_force"]
