"""Entries of COCO's tables for one image, and its panoptic segments; what COCO's tools do not know, they pass over.

Entries name their class as ``category``; its number takes that place when the tables are put together.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Int32, UInt8
from scipy.ndimage import find_objects

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.files.plain import lens_row
from warehouse_sim.dataset.files.run_lengths import compressed
from warehouse_sim.dataset.formats.observation_files import VISIBLE_ENOUGH, LabelledTarget, box_xywh
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.schema import Observation
from warehouse_sim.schema.classes import is_stuff

VOID = 0
_MOST = 2**24 - 1


def segments(
    instance_mask: Int32[np.ndarray, "h w"], class_of: Mapping[int, str], where: str
) -> tuple[Int32[np.ndarray, "h w"], list[dict[str, Any]]]:
    """Return the image of segment ids and an entry of ``segments_info`` for each, in order of the ids.

    A thing's segment has its instance id, that of stuff the smallest instance id of its class in the image.

    Args:
        instance_mask: Instance by pixel, 0 = background.
        class_of: Class of each instance; pixels of an id without a class are void.
        where: Format and observation, for the message.

    Raises:
        DatasetError: An id does not fit into the three channels of the image.
    """
    lowest, highest = int(instance_mask.min()), int(instance_mask.max())
    if lowest < 0 or highest > _MOST:
        raise DatasetError(f"{where}: instance id {lowest if lowest < 0 else highest} must be 0 to {_MOST}")
    present = np.flatnonzero(np.bincount(instance_mask.ravel()))
    segment_of = np.zeros(highest + 1, dtype=np.int32)
    first_of: dict[str, int] = {}
    for number in (int(item) for item in present if int(item) in class_of and item > 0):
        name = class_of[number]
        segment_of[number] = first_of.setdefault(name, number) if is_stuff(name) else number
    image = segment_of[instance_mask]
    return image, [_row(number, class_of[number], area, box) for number, area, box in _measured(image)]


def id_colors(image: Int32[np.ndarray, "h w"]) -> UInt8[np.ndarray, "h w 3"]:
    """Return segment ids as colours: id = R + 256 G + 256^2 B."""
    return np.stack([image & 255, (image >> 8) & 255, image >> 16], axis=-1).astype(np.uint8)


def _measured(image: Int32[np.ndarray, "h w"]) -> list[tuple[int, int, list[int]]]:
    """Return id, pixels and COCO's box (px) of each segment."""
    counts = np.bincount(image.ravel())
    counts[VOID] = 0
    numbers = np.flatnonzero(counts)
    place = np.zeros(len(counts), dtype=np.int32)
    place[numbers] = np.arange(1, len(numbers) + 1)
    return [
        (number, int(counts[number]), [columns.start, rows.start, columns.stop - columns.start, rows.stop - rows.start])
        for number, (rows, columns) in zip(numbers.tolist(), find_objects(place[image]), strict=True)
    ]


def _row(number: int, name: str, area: int, box: list[int]) -> dict[str, Any]:
    return {"id": number, "category": name, "area": area, "bbox": box, "iscrowd": 0}


def image_row(observation: Observation, number: int, name: str) -> dict[str, Any]:
    """Return an entry of ``images``, with the camera beside what COCO requires; metres."""
    camera = observation.camera
    row = {
        "id": number,
        "file_name": f"{name}.png",
        "width": camera.width,
        "height": camera.height,
        "scene_id": observation.scene_index,
        "observation": observation.observation_index,
        "K": camera.K,
        **lens_row(camera),
        "T_world_camera": observation.T_world_camera,
    }
    lux = observation.conditions.floor_lux
    return to_mapping(row if lux is None else row | {"floor_lux": lux})


def instance_row(image_number: int, target: LabelledTarget) -> dict[str, Any]:
    """Return an annotation of the visible part of a target: its mask, its box, its area."""
    annotation = target.annotation
    row = {
        **_common(image_number, target),
        "segmentation": compressed(target.runs_visible),
        "bbox": box_xywh(target.box_visible_xyxy, extra=1),
        "area": annotation.pixels_visible,
        "bbox_amodal": box_xywh(annotation.box_amodal_xyxy, extra=1),
        "pixels_all": annotation.pixels_all,
        "pixels_valid": annotation.pixels_valid,
        # Third-party masks may have no pose.
        **({"T_camera_object": annotation.T_camera_object} if np.isfinite(annotation.T_camera_object).all() else {}),
    }
    lux = annotation.illuminance
    return to_mapping(row if lux is None else row | {"lux": lux})


def amodal_row(image_number: int, target: LabelledTarget) -> dict[str, Any]:
    """Return an annotation of the whole amodal mask of a target as far as it lies in the image.

    ``bbox_uncut`` is the box of the amodal mask wherever it lies.
    """
    annotation = target.annotation
    box = mask_box_xyxy(target.mask)
    assert box is not None
    row = {
        **_common(image_number, target),
        "segmentation": compressed(target.runs),
        "bbox": box_xywh(box, extra=1),
        "area": annotation.pixels_in_image,
        "bbox_uncut": box_xywh(annotation.box_amodal_xyxy, extra=1),
        "pixels_all": annotation.pixels_all,
    }
    return to_mapping(row)


def _common(image_number: int, target: LabelledTarget) -> dict[str, Any]:
    annotation = target.annotation
    # COCO's evaluation overwrites "ignore" with "iscrowd", so that both say it.
    ignored = int(annotation.visible_fraction < VISIBLE_ENOUGH)
    return {
        "image_id": image_number,
        "category": annotation.class_name,
        "iscrowd": ignored,
        "ignore": ignored,
        "instance_id": annotation.instance_id,
        "obj_id": annotation.obj_id,
        "visible_fraction": annotation.visible_fraction,
    }
