"""Entries of COCO's tables for one image; what COCO's tools do not know, they pass over.

Entries name their class as ``category``; its number takes that place when the tables are put together.
"""

from typing import Any

import numpy as np

from warehouse_sim.dataset.files.plain import lens_row, plain
from warehouse_sim.dataset.files.run_lengths import compressed
from warehouse_sim.dataset.formats.observation_files import LabelledTarget
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.schema import Observation

VISIBLE_ENOUGH = 0.1
"""Targets of a smaller visible fraction are regions to ignore, as in BOP."""


def image_row(observation: Observation, number: int, name: str) -> dict[str, Any]:
    """Return an entry of ``images``, with the camera beside what COCO asks for; metres."""
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
    return _plain(row if lux is None else row | {"floor_lux": lux})


def instance_row(image_number: int, target: LabelledTarget) -> dict[str, Any]:
    """Return an annotation of the visible part of a target: its mask, its box, its area."""
    annotation = target.annotation
    # Every labelled target has visible pixels, so the box is there.
    assert annotation.box_visible_xyxy is not None
    row = {
        **_common(image_number, target),
        "segmentation": compressed(target.runs_visible),
        "bbox": box_xywh(annotation.box_visible_xyxy),
        "area": annotation.pixels_visible,
        "bbox_amodal": box_xywh(annotation.box_amodal_xyxy),
        "pixels_all": annotation.pixels_all,
        "pixels_valid": annotation.pixels_valid,
        # Others' masks may have no pose.
        **({"T_camera_object": annotation.T_camera_object} if np.isfinite(annotation.T_camera_object).all() else {}),
    }
    lux = annotation.illuminance
    return _plain(row if lux is None else row | {"lux": lux})


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
        "bbox": box_xywh(box),
        "area": annotation.pixels_in_image,
        "bbox_uncut": box_xywh(annotation.box_amodal_xyxy),
        "pixels_all": annotation.pixels_all,
    }
    return _plain(row)


def box_xywh(box_xyxy: tuple[float, float, float, float]) -> list[float]:
    """Return COCO's left, top, width and height (px) of inclusive corners; whole numbers stay whole."""
    left, top, right, bottom = (int(value) if float(value).is_integer() else float(value) for value in box_xyxy)
    return [left, top, right - left + 1, bottom - top + 1]


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


def _plain(row: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = plain(row)
    return found
