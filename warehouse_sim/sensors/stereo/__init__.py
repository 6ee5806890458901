"""A second camera to the right of the first: what it reads, and disparities, true and matched."""

from warehouse_sim.sensors.stereo.disparity import SgbmConfig, StereoConfig, gt_disparity, match_sgbm, seen_in_both
from warehouse_sim.sensors.stereo.read import StereoCamera, T_camera_right, read_stereo

__all__ = [
    "SgbmConfig",
    "StereoCamera",
    "StereoConfig",
    "T_camera_right",
    "gt_disparity",
    "match_sgbm",
    "read_stereo",
    "seen_in_both",
]
