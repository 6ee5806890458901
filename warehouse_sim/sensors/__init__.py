"""Config and clean images -> what a real sensor would read; every sensor has a random stream of its own."""

from warehouse_sim.registry import Registry

SENSORS = Registry("sensor")
SENSORS.add("rgbd", "warehouse_sim.sensors.rgbd:RgbdConfig")
SENSORS.add("lidar", "warehouse_sim.sensors.lidar:Lidar")
SENSORS.add("imu", "warehouse_sim.sensors.imu:Imu")
SENSORS.add("stereo", "warehouse_sim.sensors.stereo:StereoCamera")

__all__ = ["SENSORS"]
