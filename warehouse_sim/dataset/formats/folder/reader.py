"""Read a bare folder: colour, depth, intrinsics and masks, without poses and objects; all of it is the split "test"."""

from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.dataset.files.image_io import decode_any_depth, decode_any_mask, decode_any_rgb, image_size_wh
from warehouse_sim.dataset.files.png import is_rgb_png
from warehouse_sim.dataset.formats.bop.reader import require_size
from warehouse_sim.dataset.formats.folder.camera import read_intrinsics, read_place
from warehouse_sim.dataset.formats.folder.files import Frame, frames_of, intrinsics_file
from warehouse_sim.dataset.formats.images_only import shapeless
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import NO_POSE, ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy

_NUMBER, CLASS_NAME = 1, "object"
"""Of the one class."""


class FolderReader:
    """A folder of images.

    Args:
        root: The folder.
    """

    has_clean = False
    splits = {"test": (0,)}  # noqa: RUF012  every folder has this one

    def __init__(self, root: Path) -> None:
        self.root = root

    @property
    def objects(self) -> dict[int, ObjectInfo]:
        """One class without a shape: nobody says what is seen."""
        return {_NUMBER: shapeless(_NUMBER, CLASS_NAME, self.root)}

    def images(self, split: str) -> list[ImageRecord]:
        """Return the images; each has a target without a pose for every mask.

        Raises:
            DatasetError: No such split, or the intrinsics cannot be read.
        """
        if split not in self.splits:
            raise DatasetError(f"{self.root}: there is no split {split!r}; a bare folder has only test")
        return self._images

    def files(self, split: str) -> list[Path]:
        """Return all files of the images, sorted."""
        path = intrinsics_file(self.root)
        images = [file for frame in self._frames for file in (frame.rgb, frame.depth, *frame.masks)]
        return sorted([*images, *([] if path is None else [path])])

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image; a grey one has three equal channels."""
        return require_size(decode_any_rgb(self._frames[image.image_id].rgb), image, "rgb")

    def rgb_file(self, image: ImageRecord) -> Path | None:
        """Return the file of the colour image where it is an 8-bit RGB image in PNG."""
        path = self._frames[image.image_id].rgb
        return path if is_rgb_png(path) else None

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth image: metres along the optical axis, 0 = no reading."""
        steps = require_size(decode_any_depth(self._frames[image.image_id].depth), image, "depth")
        return steps.astype(np.float32) * np.float32(image.depth_scale / 1000.0)

    def clean_rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Reject: nobody else stores it."""
        raise DatasetError(f"{self.root}: holds no clean images")

    def clean_depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Reject: nobody else stores it."""
        raise DatasetError(f"{self.root}: holds no clean images")

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target."""
        return require_size(decode_any_mask(self._frames[image.image_id].masks[gt_index]), image, "mask")

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target: what is hidden of it nobody knows."""
        return self.mask_visible(image, gt_index)

    @cached_property
    def _frames(self) -> list[Frame]:
        return frames_of(self.root)

    @cached_property
    def _images(self) -> list[ImageRecord]:
        path = intrinsics_file(self.root)
        if path is None:
            raise DatasetError(f"{self.root}: says nothing of the camera; add intrinsics.json with fx, fy, cx, cy")
        intrinsics, T_world_camera = read_intrinsics(path), read_place(self.root)
        return [
            ImageRecord(
                split="test",
                scene_id=0,
                image_id=index,
                camera=intrinsics.camera(image_size_wh(frame.rgb), str(path)),
                T_world_camera=T_world_camera,
                depth_scale=intrinsics.depth_scale,
                targets=tuple(_target(number, path) for number, path in enumerate(frame.masks)),
            )
            for index, frame in enumerate(self._frames)
        ]


def _target(number: int, path: Path) -> TargetRecord:
    mask = decode_any_mask(path)
    left, top, right, bottom = (float(value) for value in mask_box_xyxy(mask) or (0, 0, -1, -1))
    pixels = int(np.count_nonzero(mask))
    return TargetRecord(
        gt_index=number,
        obj_id=_NUMBER,
        instance_id=0,
        T_camera_object=NO_POSE,
        visible_fraction=1.0 if pixels else 0.0,
        pixels_visible=pixels,
        box_visible_xyxy=(left, top, right, bottom),
        box_amodal_xyxy=(left, top, right, bottom),
        pixels_valid=pixels,
        pixels_all=max(pixels, 1),
    )
