"""The sensors of one vehicle and how they are mounted."""

from warehouse_sim.sensors.rig.calibration import CalibrationConfig, CalibrationError
from warehouse_sim.sensors.rig.camera import CAMERA_PRESETS, CameraConfig, camera_settings, depth_of
from warehouse_sim.sensors.rig.camera_file import read_camera_file
from warehouse_sim.sensors.rig.config import RigConfig
from warehouse_sim.sensors.rig.mount import FurtherSensor, Mount, MountedLidar, MountedSensor
from warehouse_sim.sensors.rig.shipped import SensorChoice, rig_names

__all__ = [
    "CAMERA_PRESETS",
    "CalibrationConfig",
    "CalibrationError",
    "CameraConfig",
    "FurtherSensor",
    "Mount",
    "MountedLidar",
    "MountedSensor",
    "RigConfig",
    "SensorChoice",
    "camera_settings",
    "depth_of",
    "read_camera_file",
    "rig_names",
]
