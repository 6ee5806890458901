"""Read a BOP folder that others made: no manifest, any depth scale, grey or JPEG images, with or without masks.

What the folder lacks is taken from what it has: without masks the boxes of scene_gt_info.json stand for them, without
boxes the masks give them. Without a split "val" every tenth image of "train" is kept apart as one.
"""

from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.dataset.formats.bop.external_models import read_models
from warehouse_sim.dataset.formats.bop.external_scene import TABLE, ExternalScene
from warehouse_sim.dataset.formats.bop.layout import NAME
from warehouse_sim.dataset.formats.bop.reader import require_size
from warehouse_sim.dataset.image_io import decode_any_depth, decode_any_mask, decode_any_rgb, is_rgb_png
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import DatasetError

_HELD_OUT = 10
"""Of so many images of train one is kept for val."""


def external_folder(root: Path) -> Path | None:
    """Return ``root`` or ``root/bop``, whichever holds scenes and models of BOP; None if neither does."""
    for folder in (root, root / NAME):
        if (folder / "models").is_dir() or (folder / "models_eval").is_dir():
            return folder
    return None


class ExternalReader:
    """A BOP folder without a manifest.

    Args:
        root: The BOP folder.
    """

    has_clean = False

    def __init__(self, root: Path) -> None:
        self.root = root
        self._folders = _split_folders(root)
        self._images: dict[str, list[ImageRecord]] = {}

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """The objects of models_info.json, or of the meshes where that is missing."""
        return read_models(self.root)

    @cached_property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Numbers of the scenes of each split; "train" and "test" also stand for folders such as train_pbr."""
        return {name: tuple(scene.scene_id for scene in self._scenes(name)) for name in self._folders}

    def images(self, split: str) -> list[ImageRecord]:
        """Return the images of a split, by scene and image id.

        Raises:
            DatasetError: No such split, or a table is missing or malformed.
        """
        if split not in self._folders:
            raise DatasetError(f"{self.root}: there is no split {split!r}; known: {', '.join(self._folders)}")
        if split not in self._images:
            self._images[split] = [image for scene in self._scenes(split) for image in scene.images(split)]
            if self._folders.get("val") is self._folders.get("train"):
                self._hold_out(split)
        return self._images[split]

    def files(self, split: str) -> list[Path]:
        """Return every file of the scenes of a split, sorted."""
        return [path for scene in self._scenes(split) for path in sorted(scene.root.rglob("*"))]

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image; a grey one has three equal channels."""
        return require_size(decode_any_rgb(self._scene(image).image_file(image.image_id)), image, "rgb")

    def rgb_file(self, image: ImageRecord) -> Path | None:
        """Return the file of the colour image, if it is an 8-bit RGB image in PNG."""
        path = self._scene(image).image_file(image.image_id)
        return path if is_rgb_png(path) else None

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth image: metres along the optical axis, 0 = no reading."""
        steps = require_size(decode_any_depth(self._scene(image).file("depth", image.image_id)), image, "depth")
        return steps.astype(np.float32) * np.float32(image.depth_scale / 1000.0)

    def clean_rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Refuse: nobody else stores it."""
        raise DatasetError(f"{self.root}: holds no clean images")

    def clean_depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Refuse: nobody else stores it."""
        raise DatasetError(f"{self.root}: holds no clean images")

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's visible pixels; the box of the visible part where there is no mask."""
        return self._mask("mask_visib", image, gt_index, image.targets[gt_index].box_visible_xyxy)

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's whole silhouette; its box in the image where there is no mask."""
        return self._mask("mask", image, gt_index, image.targets[gt_index].box_amodal_xyxy)

    def _mask(
        self, kind: str, image: ImageRecord, gt_index: int, box_xyxy: tuple[float, float, float, float]
    ) -> Bool[np.ndarray, "h w"]:
        path = self._scene(image).find_mask(kind, image.image_id, gt_index)
        if path is not None:
            return require_size(decode_any_mask(path), image, kind)
        mask = np.zeros((image.camera.height, image.camera.width), dtype=bool)
        left, top, right, bottom = np.rint(np.clip(box_xyxy, -1, 65_536)).astype(int)
        mask[max(top, 0) : max(bottom + 1, 0), max(left, 0) : max(right + 1, 0)] = True
        return mask

    def _scenes(self, split: str) -> list[ExternalScene]:
        folder = self._folders[split]
        return [ExternalScene(path, int(path.name)) for path in sorted(folder.iterdir()) if _is_scene(path)]

    def _scene(self, image: ImageRecord) -> ExternalScene:
        return ExternalScene(self._folders[image.split] / f"{image.scene_id:06d}", image.scene_id)

    def _hold_out(self, split: str) -> None:
        """Keep every tenth image of train apart for val, the last where there are fewer."""
        images = self._images[split]
        held = set(range(_HELD_OUT - 1, len(images), _HELD_OUT) or [len(images) - 1])
        if split in ("train", "val"):
            self._images[split] = [item for i, item in enumerate(images) if (i in held) == (split == "val")]


def _is_scene(path: Path) -> bool:
    return path.name.isdecimal() and (path / TABLE.format("camera")).is_file()


def _split_folders(root: Path) -> dict[str, Path]:
    """Return the folder of each split: "train", "val" and "test", then all others by their own names."""
    found = [path for path in sorted(root.iterdir()) if path.is_dir() and any(map(_is_scene, path.iterdir()))]
    by_name: dict[str, Path] = {}
    for split in SPLITS:
        exact = [path for path in found if path.name == split]
        alike = [path for path in found if path.name.startswith(f"{split}_")]
        if exact or alike:
            by_name[split] = (exact or alike)[0]
    if "train" in by_name:
        by_name.setdefault("val", by_name["train"])
    used = set(by_name.values())
    return by_name | {path.name: path for path in found if path not in used}
