"""Rows of KITTI's label files, from targets to text, and the camera of a calib file; ``tolerant`` reads the files."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import lens_of
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_y
from warehouse_sim.schema import ObjectAnnotation

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

    @classmethod
    def of(cls, kind: str, occluded: int, values: Sequence[float]) -> Self:
        """Return a label of its type, its level of occlusion, and all other fields of the row in order."""
        truncated, alpha, left, top, right, bottom, height, width, length, x, y, z, heading = values
        return cls(
            kind,
            truncated,
            occluded,
            alpha,
            (left, top, right, bottom),
            (height, width, length),
            (x, y, z),
            heading,
        )

    @property
    def is_dont_care(self) -> bool:
        """Whether only its type and 2D box mean anything."""
        return self.type == DONT_CARE

    def T_camera_object(self) -> Transform:
        """Return the pose of the upright box's centre frame (x length, y width, z up)."""
        centre = np.array(self.location) - [0.0, self.size_hwl[0] / 2.0, 0.0]
        return make_transform(rotation_y(self.rotation_y) @ _R_object_box.T, centre)


CALIB_KEYS = ("P0", "P1", "P2", "P3", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo")
"""The seven lines of a calib file, in the order by which loaders find them."""


def calib_camera(matrices: Mapping[str, Float[np.ndarray, "rows columns"]], size_wh: tuple[int, int]) -> PinholeCamera:
    """Return camera 2 of a calib file as read, with its lens if it has one.

    Args:
        matrices: What ``read_calib`` returns.
        size_wh: Width and height of the images (px), which the file does not hold.

    Raises:
        DatasetError: P2 or the lens is that of no camera.
    """
    (fx, _, cx), (_, fy, cy) = matrices["P2"][:2, :3]
    lines = [matrices[key] for key in ("D_02", "F_02") if key in matrices]
    try:
        distortion = lens_of(lines[0][0].tolist()) if lines else None
    except ValueError as problem:
        raise DatasetError(f"the lens of a calib file: {problem}") from problem
    if min(fx, fy) <= 0.0:
        raise DatasetError(f"P2 of a calib file must have focal lengths above 0, found {fx} and {fy}")
    return PinholeCamera(*size_wh, float(fx), float(fy), float(cx), float(cy), distortion)


LARGEST_TILT = math.radians(2.0)
"""An object leaning more than this is not described by an upright box."""


def label_rows(
    annotations: Sequence[ObjectAnnotation], camera: PinholeCamera, where: str
) -> tuple[list[str], list[int]]:
    """Return the rows of a label file and the instance id of each; at least one, as OpenPCDet reads no empty file.

    What leans is DontCare and comes after the others, where readers expect it.

    Args:
        annotations: The labelled targets of an image.
        camera: Its intrinsics.
        where: Scene and observation, for the message.

    Raises:
        DatasetError: A class name is not one word.
    """
    upright = [item for item in annotations if tilt(item.T_camera_object) <= LARGEST_TILT]
    leaning = [item for item in annotations if tilt(item.T_camera_object) > LARGEST_TILT]
    rows = [label_line(kitti_label(item, camera, where)) for item in upright]
    rows += [_dont_care(_cut(item.box_amodal_xyxy, camera)) for item in leaning]
    ids = [item.instance_id for item in (*upright, *leaning)]
    return (rows, ids) if rows else ([_dont_care((0.0, 0.0, 0.0, 0.0))], [0])


def tilt(T_camera_object: Transform) -> float:
    """Return by how much an object leans in a level camera's frame (rad, 0 to pi)."""
    # Camera y points down, so an upright object has its z axis along camera -y. Unlike arccos, this keeps small angles.
    x, y, z = T_camera_object[:3, 2]
    return math.atan2(math.hypot(x, z), -y)


def kitti_label(annotation: ObjectAnnotation, camera: PinholeCamera, where: str) -> KittiLabel:
    """Describe a labelled target that stands by an upright box with the object's own centre, size and heading.

    Args:
        annotation: A target with visible pixels.
        camera: Intrinsics; the box is cut at its image.
        where: Scene and observation, for the message.

    Raises:
        DatasetError: Its class name is not one word.
    """
    T_camera_object = annotation.T_camera_object
    if not annotation.class_name or len(annotation.class_name.split()) != 1:
        raise DatasetError(f"{where}: the class name {annotation.class_name!r} must be one word in a KITTI label")
    return replace(
        upright_label(annotation.class_name, annotation.size, T_camera_object),
        truncated=annotation.truncation,
        occluded=annotation.occlusion_level,
        box_xyxy=_cut(annotation.box_amodal_xyxy, camera),
    )


def upright_label(name: str, size: Float[np.ndarray, " 3"], T_camera_object: Transform) -> KittiLabel:
    """Return an upright box with an object's centre, size and heading, in no image and of unknown visibility.

    Args:
        name: Class.
        size: Length, width and height (m).
        T_camera_object: Pose of its centre frame (x along its length, z up) in the rectified frame.
    """
    length, width, height = (float(edge) for edge in size)
    x, y, z = (float(value) for value in T_camera_object[:3, 3])
    heading = math.atan2(-T_camera_object[2, 0], T_camera_object[0, 0])
    return KittiLabel(
        type=name,
        truncated=-1.0,
        occluded=-1,
        alpha=_wrap(heading - math.atan2(x, z)),
        box_xyxy=(0.0, 0.0, 0.0, 0.0),
        size_hwl=(height, width, length),
        location=(x, y + height / 2.0, z),
        rotation_y=heading,
    )


def label_line(label: KittiLabel) -> str:
    """Return a row without a line end."""
    numbers = [*(_fixed(value, 2) for value in label.box_xyxy)]
    numbers += [_fixed(value, 6) for value in (*label.size_hwl, *label.location, label.rotation_y)]
    head = f"{label.type} {_fixed(label.truncated, 4)} {label.occluded} {_fixed(label.alpha, 6)}"
    return f"{head} {' '.join(numbers)}"


def _dont_care(box_xyxy: tuple[float, float, float, float]) -> str:
    box = " ".join(_fixed(value, 2) for value in box_xyxy)
    return f"{DONT_CARE} -1 -1 -10 {box} -1 -1 -1 -1000 -1000 -1000 -10"


def _cut(box_xyxy: tuple[float, float, float, float], camera: PinholeCamera) -> tuple[float, float, float, float]:
    left, top, right, bottom = box_xyxy
    last_u, last_v = float(camera.width - 1), float(camera.height - 1)
    return max(left, 0.0), max(top, 0.0), min(right, last_u), min(bottom, last_v)


def _wrap(angle: float) -> float:
    return math.atan2(math.sin(angle), math.cos(angle))


def _fixed(value: float, digits: int) -> str:
    # Adding zero turns "-0.00" into "0.00".
    return f"{round(value, digits) + 0.0:.{digits}f}"
