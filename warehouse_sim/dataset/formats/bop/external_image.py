"""The labels of one image of a third-party BOP folder: rows that may be short, masks that may be missing."""

import logging
from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.files.plain import (
    FRACTIONS,
    PLACES,
    WHOLE,
    Span,
    nearest_rotation,
    take,
    take_if_given,
    take_numbers,
)
from warehouse_sim.dataset.formats.bop.tables import DEPTH_SCALES, read_box, read_camera
from warehouse_sim.dataset.formats.reader_base import Box
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.pose import Transform, invert, make_transform

_EVERY = 10


def held_out(images: list[ImageRecord], split: str) -> list[ImageRecord]:
    """Return of the images of train those that stay there, or those that stand for val.

    Args:
        images: Of train.
        split: "train" or "val", which is every tenth, or the last where there are fewer.
    """
    held = set(range(_EVERY - 1, len(images), _EVERY) or [len(images) - 1])
    return [item for i, item in enumerate(images) if (i in held) == (split == "val")]


log = logging.getLogger(__name__)

MaskReader = Callable[[str, int], Bool[np.ndarray, "h w"] | None]
"""Takes "mask" or "mask_visib" and the index of a label; None where there is no such mask."""
_PLACES_MM = Span(1000.0 * PLACES.low, 1000.0 * PLACES.high)
_NOWHERE: Box = (-1.0, -1.0, -2.0, -2.0)
"""What bop_toolkit's box of no pixel, [-1, -1, -1, -1], is as corners."""


@dataclass(frozen=True)
class ExternalRows:
    """What a folder says of one image; where it says nothing, poses and infos are None."""

    camera: Any
    poses: Any
    infos: Any
    read_mask: MaskReader
    camera_where: str
    """File and key of the camera, for messages."""
    poses_where: str


def external_image(
    split: str, numbers: tuple[int, int], size_wh: tuple[int, int], rows: ExternalRows, known: Collection[int]
) -> ImageRecord:
    """Read one image; one without labels has no targets.

    Args:
        split: The split it belongs to.
        numbers: Scene and image.
        size_wh: Width and height of the image in pixels.
        rows: What the folder says of it.
        known: Numbers of the objects that have a mesh; labels of others are left out, with a warning.

    Raises:
        DatasetError: A row is malformed, or neither it nor a mask says where a target is in its image.
    """
    camera, where = rows.camera, rows.camera_where
    placed = isinstance(camera, dict) and "cam_R_w2c" in camera
    T_camera_world = read_rounded_pose(camera, "cam_R_w2c", "cam_t_w2c", where) if placed else np.eye(4)
    poses = take({"labels": [] if rows.poses is None else rows.poses}, "labels", list, rows.poses_where)
    infos = rows.infos or [{}] * len(poses)
    if not isinstance(infos, list) or len(infos) != len(poses):
        raise DatasetError(f"{rows.poses_where}: scene_gt and scene_gt_info list other objects of this image")
    numbered = [(i, pose, take(pose, "obj_id", int, f"{rows.poses_where}[{i}]", WHOLE)) for i, pose in enumerate(poses)]
    strange = sorted({obj_id for _, _, obj_id in numbered if obj_id not in known})
    if strange:
        _warn_of(str(Path(rows.poses_where).parent), tuple(strange))
    return ImageRecord(
        split=split,
        scene_id=numbers[0],
        image_id=numbers[1],
        camera=read_camera(camera, size_wh, where),
        T_world_camera=invert(T_camera_world),
        depth_scale=take_if_given(camera, "depth_scale", float, where, DEPTH_SCALES) or 1.0,
        targets=tuple(_target(i, pose, infos[i], rows) for i, pose, obj_id in numbered if obj_id in known),
    )


@lru_cache
def _warn_of(folder: str, numbers: tuple[int, ...]) -> None:
    """Warn once a folder, not once an image."""
    log.warning("%s: labels of objects without a mesh are left out: %s", folder, list(numbers))


def _target(index: int, pose: Any, info: Any, rows: ExternalRows) -> TargetRecord:
    where = f"{rows.poses_where}[{index}]"
    visible, whole = (_box(kind, key, index, info, rows.read_mask, where) for kind, key in _BOXES)
    seen, whole = visible or whole, whole or visible
    if seen is None or whole is None:
        raise DatasetError(
            f"{where}: neither bbox_visib or bbox_obj in scene_gt_info.json nor a file in mask_visib or mask says "
            "where the target is in its image; make them with bop_toolkit's calc_gt_masks, calc_gt_info"
        )
    seen_pixels = take_if_given(info, "px_count_visib", int, where, WHOLE)
    all_pixels = take_if_given(info, "px_count_all", int, where, WHOLE)
    seen_pixels = _pixels("mask_visib", index, seen, rows.read_mask) if seen_pixels is None else seen_pixels
    all_pixels = max(_pixels("mask", index, whole, rows.read_mask), 1) if all_pixels is None else all_pixels
    fraction = take_if_given(info, "visib_fract", float, where, FRACTIONS)
    valid = take_if_given(info, "px_count_valid", int, where, WHOLE)
    return TargetRecord(
        gt_index=index,
        obj_id=take(pose, "obj_id", int, where, WHOLE),
        instance_id=take_if_given(info, "instance_id", int, where, WHOLE) or 0,
        T_camera_object=read_rounded_pose(pose, "cam_R_m2c", "cam_t_m2c", where),
        visible_fraction=min(seen_pixels / max(all_pixels, 1), 1.0) if fraction is None else fraction,
        pixels_visible=seen_pixels,
        box_visible_xyxy=seen,
        box_amodal_xyxy=whole,
        pixels_valid=seen_pixels if valid is None else valid,
        pixels_all=all_pixels,
    )


_BOXES = (("mask_visib", "bbox_visib"), ("mask", "bbox_obj"))


def _box(kind: str, key: str, index: int, info: Any, read_mask: MaskReader, where: str) -> Box | None:
    """Return a box from the table, else that of the mask, if there is either; an empty mask has a box of nothing."""
    if take_if_given(info, key, list, where) is not None:
        return read_box(info, key, where)
    mask = read_mask(kind, index)
    if mask is None:
        return None
    box = mask_box_xyxy(mask)
    return _NOWHERE if box is None else (float(box[0]), float(box[1]), float(box[2]), float(box[3]))


def _pixels(kind: str, index: int, box: Box, read_mask: MaskReader) -> int:
    mask = read_mask(kind, index)
    if mask is not None:
        return int(np.count_nonzero(mask))
    left, top, right, bottom = box
    return max(int(right - left + 1), 0) * max(int(bottom - top + 1), 0)


def read_rounded_pose(data: Any, rotation: str, translation: str, where: str) -> Transform:
    """Read a pose in millimetres; a rotation whose numbers were rounded becomes the nearest one.

    Raises:
        DatasetError: It is missing, or far from any rotation.
    """
    R = take_numbers(data, rotation, 9, where).reshape(3, 3)
    return make_transform(
        nearest_rotation(R, f"{where}: {rotation}"), take_numbers(data, translation, 3, where, _PLACES_MM) / 1000.0
    )
