"""Read a third-party YOLO folder (or of one task of ours): images, classes, boxes masks of polygons; no poses."""

from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import Bool, Float, UInt8

from warehouse_sim.dataset.files.image_io import decode_any_rgb, image_size_wh
from warehouse_sim.dataset.formats.bop.reader import require_size
from warehouse_sim.dataset.formats.images_only import (
    ImagesOnly,
    box_mask,
    guessed_camera,
    inside,
    require_split,
    shapeless,
)
from warehouse_sim.dataset.formats.yolo.tables import Label, YoloData, read_data, read_labels
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import NO_POSE, ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy

_ENDINGS = frozenset((".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"))


class YoloReader(ImagesOnly):
    """A folder with a ``data.yaml``; classes are numbered from 1 here, as objects are.

    Args:
        root: The folder.
    """

    lacks = ("ground-truth masks",)
    """Polygons stand for them."""

    def __init__(self, root: Path) -> None:
        super().__init__(root)
        self._data: YoloData = read_data(root)
        self._files: dict[str, list[Path]] = {}
        self._images: dict[str, list[ImageRecord]] = {}

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """The classes, of whose shape nothing is known, by number + 1."""
        return {number + 1: shapeless(number + 1, name, self.root) for number, name in self._data.names.items()}

    @cached_property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Each split is one scene."""
        return {split: (number,) for number, split in enumerate(self._data.folders)}

    def images(self, split: str) -> list[ImageRecord]:
        """Return the images of a split in order of their names.

        Raises:
            DatasetError: No such split, or a file is missing or malformed.
        """
        require_split(self._data.folders, split, self.root)
        if split not in self._images:
            self._images[split] = [self._image(split, i, path) for i, path in enumerate(self._paths(split))]
        return self._images[split]

    def files(self, split: str) -> list[Path]:
        """Return images and labels of a split, sorted."""
        require_split(self._data.folders, split, self.root)
        labels = [path for path in map(label_path, self._paths(split)) if path.is_file()]
        return sorted([*self._paths(split), *labels])

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image; a grey one has three equal channels."""
        return require_size(decode_any_rgb(self._paths(image.split)[image.image_id]), image, "the image")

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target; its box where its label is no polygon."""
        label = self._labels(image.split, image.image_id)[gt_index]
        if label.polygon is None:
            return box_mask(image.targets[gt_index].box_visible_xyxy, image.camera)
        return _filled(label.polygon, image.camera.width, image.camera.height)

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the same mask: labels hold no other."""
        return self.mask_visible(image, gt_index)

    def _paths(self, split: str) -> list[Path]:
        if split not in self._files:
            folder = inside(self.root, self._data.folders[split], f"{self.root / 'data.yaml'}: {split}")
            if not folder.is_dir():
                raise DatasetError(f"{self.root / 'data.yaml'}: {split} is {folder}, which is no folder in the dataset")
            found = (path for path in folder.rglob("*") if path.suffix.lower() in _ENDINGS)
            self._files[split] = sorted(found)
        return self._files[split]

    def _labels(self, split: str, image_id: int) -> list[Label]:
        return read_labels(label_path(self._paths(split)[image_id]), self._data)

    def _image(self, split: str, image_id: int, path: Path) -> ImageRecord:
        width, height = image_size_wh(path)
        targets = [_target(i, label, width, height) for i, label in enumerate(self._labels(split, image_id))]
        camera, (scene_id,) = guessed_camera(width, height), self.splits[split]
        return ImageRecord(split, scene_id, image_id, camera, np.eye(4), 1.0, tuple(targets), calibrated=False)


def label_path(image: Path) -> Path:
    """Return the label file of an image: the last folder ``images`` of its path becomes ``labels``."""
    parts: list[Any] = list(image.parts)
    folders = [i for i, part in enumerate(parts[:-1]) if part == "images"]
    if folders:
        parts[folders[-1]] = "labels"
    return Path(*parts).with_suffix(".txt")


def _target(index: int, label: Label, width: int, height: int) -> TargetRecord:
    left, top, right, bottom = label.box_xyxy * [width, height, width, height]
    box = float(left), float(top), max(float(right) - 1, float(left)), max(float(bottom) - 1, float(top))
    seen = round((box[2] - box[0] + 1) * (box[3] - box[1] + 1))
    if label.polygon is not None:
        mask = _filled(label.polygon, width, height)
        found = mask_box_xyxy(mask)
        if found is not None:
            box, seen = (float(found[0]), float(found[1]), float(found[2]), float(found[3])), int(mask.sum())
    return TargetRecord(index, label.number + 1, 0, NO_POSE, 1.0, seen, box, box, seen, max(seen, 1))


def _filled(polygon: Float[np.ndarray, "n 2"], width: int, height: int) -> Bool[np.ndarray, "h w"]:
    """Return the pixels of a polygon given in fractions of the image, filled as Ultralytics does."""
    image = np.zeros((height, width), dtype=np.uint8)
    cv2.fillPoly(image, [np.trunc(polygon * [width, height]).astype(np.int32)], 1)
    return image.view(bool)
