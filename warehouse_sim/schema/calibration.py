"""What a rig says of itself, where that differs from what it is."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform


@dataclass(frozen=True, eq=False)
class NominalCalibration:
    """The calibration of one observation that an estimator gets; images and labels are those of the true one."""

    camera: PinholeCamera
    """Intrinsics and lens of the rig's camera."""
    depth_factor: float = 1.0
    """Metres that are said to be one metre of the depth image as it is stored."""
    T_camera_sensor: Mapping[str, Transform] = field(default_factory=dict)
    """Pose in the camera frame of each sensor that is calibrated to it, by name; what its clock errs is in it."""
    time_offset: Mapping[str, float] = field(default_factory=dict)
    """How much later than the camera's moment each of them is said to have read, though it read then (s)."""
