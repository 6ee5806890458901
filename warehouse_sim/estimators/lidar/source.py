"""Whose depth estimators see; free of anything heavy, for settings."""

from typing import Literal

DepthSource = Literal["camera", "lidar", "lidar-sparse"]
"""The camera's own, the main LiDAR's filled up, or only where it has points."""
