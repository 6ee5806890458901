"""Config and clean truth -> what a real sensor would read; every sensor draws from a random stream of its own."""

from warehouse_sim.registry import Registry

SENSORS = Registry("sensor")
SENSORS.add("rgbd", "warehouse_sim.sensors.rgbd:RgbdConfig")
SENSORS.add("lidar", "warehouse_sim.sensors.lidar:LidarConfig")

__all__ = ["SENSORS"]
