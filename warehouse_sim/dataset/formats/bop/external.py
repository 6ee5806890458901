"""Read a third-party BOP folder: no manifest, any depth scale, grey or JPEG images, with or without masks.

What the folder lacks is taken from what it has: without masks the boxes of scene_gt_info.json stand for them, without
boxes the masks give them. Without a split "val" every tenth image of "train" is kept apart as one.
"""

import logging
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import WHOLE, take
from warehouse_sim.dataset.formats.bop import NAME, BopLayout
from warehouse_sim.dataset.formats.bop.external_models import model_folders, read_models
from warehouse_sim.dataset.formats.bop.external_split import (
    KeyedSplit,
    ScenewiseSplit,
    held_out,
    is_scene,
    keyed_folder,
)
from warehouse_sim.dataset.formats.bop.shards import COMPACT
from warehouse_sim.dataset.formats.bop.shards import NAME as SHARDS
from warehouse_sim.dataset.formats.reader_base import Box, ReaderBase, box_mask, metres, require_size
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import DatasetError

ImageSource = ScenewiseSplit | KeyedSplit
"""The images of one split, whatever their files are."""
log = logging.getLogger(__name__)
_YEARS = (2024, 2019)


def only_requested(root: Path, images: Sequence[ImageRecord]) -> list[ImageRecord]:
    """Return those images that test_targets_bop24.json, or else bop19, names; all where there is neither.

    Raises:
        DatasetError: A list is malformed, or names none of the images.
    """
    path = next((path for year in _YEARS if (path := BopLayout(root).targets(year)).is_file()), None)
    if path is None:
        return list(images)
    rows = take({"targets": read_json(path)}, "targets", list, str(path))
    requested = {
        (take(row, "scene_id", int, f"{path}: [{i}]", WHOLE), take(row, "im_id", int, f"{path}: [{i}]", WHOLE))
        for i, row in enumerate(rows)
    }
    kept = [image for image in images if (image.scene_id, image.image_id) in requested]
    if images and not kept:
        raise DatasetError(
            f"{path}: names none of the {len(images)} test images; remove it or get the list of this set"
        )
    if len(kept) < len(images):
        log.info("%s: %d of %d test images are requested", path, len(kept), len(images))
    return kept


def external_folder(root: Path) -> Path | None:
    """Return ``root`` or the folder of one of BOP's formats in it: the first that has models and images, if any."""
    for folder in (root, root / NAME, root / SHARDS, root / COMPACT):
        if folder.is_dir() and model_folders(folder) and any(map(_holds_images, folder.iterdir())):
            return folder
    return None


class ExternalReader(ReaderBase):
    """A BOP folder without a manifest.

    Args:
        root: The BOP folder.
    """

    def __init__(self, root: Path) -> None:
        self._sources = _sources(root)
        super().__init__(root, self._sources)

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """The objects of models_info.json, or of the meshes where that is missing."""
        return read_models(self.root)

    @cached_property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Numbers of the scenes of each split; "train" and "test" also stand for folders such as train_pbr."""
        return {name: source.scene_ids for name, source in self._sources.items()}

    def _read(self, split: str) -> list[ImageRecord]:
        images = self._sources[split].images(split, set(self.objects))
        if split in ("train", "val") and self._sources["val"] is self._sources.get("train"):
            images = held_out(images, split)
        # Of "test" those that a list of targets names.
        return only_requested(self.root, images) if split == "test" else images

    def files(self, split: str) -> list[Path]:
        """Return every file of the scenes of a split, sorted."""
        return self._sources[split].files()

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image; a grey one has three equal channels."""
        return require_size(self._sources[image.split].rgb(image), image, "rgb")

    def rgb_file(self, image: ImageRecord) -> Path | None:
        """Return the file of the colour image where it is an 8-bit RGB image in PNG."""
        return self._sources[image.split].rgb_file(image)

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth image: metres along the optical axis, 0 = no reading."""
        return metres(self._sources[image.split].steps(image), image)

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's visible pixels; the box of the visible part where there is no mask."""
        return self._mask("mask_visib", image, gt_index, lambda target: target.box_visible_xyxy)

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's whole amodal mask; its box in the image where there is no mask."""
        return self._mask("mask", image, gt_index, lambda target: target.box_amodal_xyxy)

    def _mask(
        self, kind: str, image: ImageRecord, gt_index: int, box_of: Callable[[TargetRecord], Box]
    ) -> Bool[np.ndarray, "h w"]:
        found = self._sources[image.split].mask(kind, image, gt_index)
        if found is not None:
            return require_size(found, image, kind)
        # Labels of unknown objects are left out: an index is not a position.
        target = next(item for item in image.targets if item.gt_index == gt_index)
        return box_mask(box_of(target), image.camera)


def _holds_images(path: Path) -> bool:
    return path.is_dir() and _source(path) is not None


def _source(path: Path) -> ImageSource | None:
    """Return the images of a folder, if it has any."""
    if any(map(is_scene, path.iterdir())):
        return ScenewiseSplit(path)
    keyed = keyed_folder(path)
    return None if keyed is None else KeyedSplit(path, keyed)


def _sources(root: Path) -> dict[str, ImageSource]:
    """Return the images of each split: "train", "val" and "test", then all others by the names of their folders."""
    folders = [path for path in sorted(root.iterdir()) if path.is_dir()]
    found = {path.name: source for path in folders if (source := _source(path)) is not None}
    by_name: dict[str, ImageSource] = {}
    for split in SPLITS:
        exact: list[str] = [name for name in found if name == split]
        names = exact or [name for name in found if name.startswith(f"{split}_")]
        if names:
            by_name[split] = found.pop(names[0])
    if "train" in by_name:
        by_name.setdefault("val", by_name["train"])
    return by_name | found
