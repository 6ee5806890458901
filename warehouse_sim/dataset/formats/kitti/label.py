"""The fields of a row of a KITTI label file, and the pose of the upright box that they describe."""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.geometry.pose import Transform, make_transform, rotation_y

DONT_CARE = "DontCare"
"""Type of what is neither to be found nor to be missed."""
# From KITTI's box axes (x length, y down, z width) to the object's (x length, y width, z up).
_R_object_box = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True)
class KittiLabel:
    """The 15 fields of a row; lengths in m, angles in rad, the box in pixels."""

    type: str
    truncated: float
    """Fraction of the amodal mask's pixels outside the image, 0-1."""
    occluded: int
    """0 from 90 % visible of what lies in the image, 1 from 50 %, 2 below."""
    alpha: float
    """Rotation seen along the viewing ray, -pi to pi."""
    box_xyxy: tuple[float, float, float, float]
    """Box of the whole amodal mask, cut at the image border, inclusive corners."""
    size_hwl: tuple[float, float, float]
    """Height, width (object y) and length (object x)."""
    location: tuple[float, float, float]
    """Centre of the bottom face in the rectified camera frame."""
    rotation_y: float
    """Angle about camera +y from camera +x to the object's x axis, -pi to pi."""

    @property
    def is_dont_care(self) -> bool:
        """Whether only its type and 2D box mean anything."""
        return self.type == DONT_CARE

    def T_camera_object(self) -> Transform:
        """Return the pose of the upright box's centre frame (x length, y width, z up)."""
        centre = np.array(self.location) - [0.0, self.size_hwl[0] / 2.0, 0.0]
        return make_transform(rotation_y(self.rotation_y) @ _R_object_box.T, centre)
