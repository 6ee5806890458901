"""One row of a KITTI label file, and the way between an object's pose and KITTI's upright box."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_y
from warehouse_sim.schema import ObjectAnnotation

DONT_CARE = "DontCare"
"""Type of what is neither to be found nor to be missed."""
LARGEST_TILT = math.radians(2.0)
"""An object leaning more than this is not described by an upright box."""
# From KITTI's box axes (x length, y down, z width) to the object's (x length, y width, z up).
_R_object_box = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True)
class KittiLabel:
    """The 15 fields of a row; lengths in m, angles in rad, the box in pixels."""

    type: str
    truncated: float
    """Share of the silhouette's pixels outside the image, 0-1."""
    occluded: int
    """0 from 90 % visible of what lies in the image, 1 from 50 %, 2 below."""
    alpha: float
    """Rotation seen along the viewing ray, -pi to pi."""
    box_xyxy: tuple[float, float, float, float]
    """Box of the whole silhouette, cut at the image border, inclusive corners."""
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

    def line(self) -> str:
        """Return the row without a line end."""
        numbers = [*(_fixed(value, 2) for value in self.box_xyxy)]
        numbers += [_fixed(value, 6) for value in (*self.size_hwl, *self.location, self.rotation_y)]
        head = f"{self.type} {_fixed(self.truncated, 4)} {self.occluded} {_fixed(self.alpha, 6)}"
        return f"{head} {' '.join(numbers)}"

    def T_camera_object(self) -> Transform:
        """Return the pose of the upright box's centre frame (x length, y width, z up)."""
        centre = np.array(self.location) - [0.0, self.size_hwl[0] / 2.0, 0.0]
        return make_transform(rotation_y(self.rotation_y) @ _R_object_box.T, centre)


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
    rows = [kitti_label(item, camera, where).line() for item in upright]
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
    length, width, height = (float(edge) for edge in annotation.size)
    x, y, z = (float(value) for value in T_camera_object[:3, 3])
    heading = math.atan2(-T_camera_object[2, 0], T_camera_object[0, 0])
    return KittiLabel(
        type=annotation.class_name,
        truncated=annotation.truncation,
        occluded=annotation.occlusion_level,
        alpha=_wrap(heading - math.atan2(x, z)),
        box_xyxy=_cut(annotation.box_amodal_xyxy, camera),
        size_hwl=(height, width, length),
        location=(x, y + height / 2.0, z),
        rotation_y=heading,
    )


def parse_label(line: str, where: str) -> KittiLabel:
    """Read a row as strictly as the strictest reader does.

    Raises:
        DatasetError: Not 15 fields with single blanks, or a field of the wrong kind.
    """
    words = line.split(" ")
    if len(words) != 15:
        raise DatasetError(f"{where}: 15 fields with single blanks are expected, found {len(words)}")
    try:
        occluded, values = int(words[2]), [float(word) for word in (words[1], *words[3:])]
    except ValueError as problem:
        raise DatasetError(f"{where}: a field is not a number ({problem})") from problem
    if not all(map(math.isfinite, values)):
        raise DatasetError(f"{where}: every field must be finite")
    truncated, alpha, left, top, right, bottom, height, width, length, x, y, z, heading = values
    return KittiLabel(
        type=words[0],
        truncated=truncated,
        occluded=occluded,
        alpha=alpha,
        box_xyxy=(left, top, right, bottom),
        size_hwl=(height, width, length),
        location=(x, y, z),
        rotation_y=heading,
    )


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
