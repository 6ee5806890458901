"""Where a sensor sits: forward, left and up of the camera or of the vehicle, and turned."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.level_view import is_level, levelled
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_x, rotation_y, rotation_z
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import Viewpoint

CAMERA_FROM_BODY = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""Rotation from axes x forward, y left, z up to a camera's x right, y down, z forward."""


@dataclass(frozen=True)
@ranged
class Mount:
    """A place and a direction on the rig; turned by yaw, then pitch, then roll about the axes that turn along."""

    carrier: Literal["camera", "upright", "vehicle"] = "camera"
    """Seen from the camera, with which it tilts and lifts; from there, but upright; or from the vehicle's origin."""
    forward: Annotated[float, Range(-20, 20, "m")] = 0.0
    """Along the optical axis, or along the vehicle (m), -20 to 20."""
    left: Annotated[float, Range(-20, 20, "m")] = 0.0
    """To the left (m), -20 to 20."""
    up: Annotated[float, Range(-20, 20, "m")] = 0.0
    """Upwards (m), -20 to 20."""
    roll_deg: Annotated[float, Range(-360, 360, "deg")] = 0.0
    """About the forward axis (deg), -360 to 360; positive lowers the right side."""
    pitch_deg: Annotated[float, Range(-360, 360, "deg")] = 0.0
    """About the left axis (deg), -360 to 360; positive looks up."""
    yaw_deg: Annotated[float, Range(-360, 360, "deg")] = 0.0
    """About the up axis (deg), -360 to 360; positive looks left."""

    def T_body_sensor(self) -> Transform:
        """Return the pose of the sensor (x forward, y left, z up) in the same axes of what carries it."""
        roll, pitch, yaw = np.deg2rad([self.roll_deg, self.pitch_deg, self.yaw_deg])
        rotation = rotation_z(yaw) @ rotation_y(-pitch) @ rotation_x(roll)
        return make_transform(rotation, np.array([self.forward, self.left, self.up]))

    def T_camera_sensor(self, viewpoint: Viewpoint | None = None) -> Transform:
        """Return the pose of the sensor (x forward, y left, z up) in the camera frame (x right, y down, z forward).

        Args:
            viewpoint: Where camera and vehicle are; not needed for what sits on the camera, nor on a level one upright.

        Raises:
            ConfigError: The sensor sits on a vehicle, but nothing carries the camera.
        """
        tilts = self.carrier == "upright" and viewpoint is not None and not is_level(viewpoint.T_world_camera)
        if self.carrier == "camera" or (self.carrier == "upright" and not tilts):
            return make_transform(CAMERA_FROM_BODY) @ self.T_body_sensor()
        if viewpoint is not None and tilts:
            T_camera_level = invert(viewpoint.T_world_camera) @ levelled(viewpoint.T_world_camera)
            return T_camera_level @ make_transform(CAMERA_FROM_BODY) @ self.T_body_sensor()
        if viewpoint is None or viewpoint.T_world_vehicle is None:
            raise ConfigError(
                "sensors: a sensor is mounted on the vehicle, but no vehicle carries this camera; "
                "mount it on the camera, or take another viewpoints.kind than free"
            )
        return invert(viewpoint.T_world_camera) @ viewpoint.T_world_vehicle @ self.T_body_sensor()
