"""LiDARs as the real ones see: lasers on a measured table, what comes back of a pulse, and when."""

from warehouse_sim.sensors.lidar.config import LIDAR_PRESETS, LidarConfig
from warehouse_sim.sensors.lidar.read import Lidar, scan

__all__ = ["LIDAR_PRESETS", "Lidar", "LidarConfig", "scan"]
