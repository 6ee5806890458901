"""Rows of a KITTI label file from labelled targets."""

import math
from collections.abc import Sequence

from warehouse_sim.dataset.formats.kitti.reader import DONT_CARE, KittiLabel
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.schema import ObjectAnnotation

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
