"""Read the BOP shards of a dataset with a manifest: members by name, at their place in the archive."""

from functools import cached_property, partial
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.dataset.files.image_io import depth_of_png, rgb_of_png
from warehouse_sim.dataset.files.json_file import parse_json
from warehouse_sim.dataset.files.png import png_header_size_wh
from warehouse_sim.dataset.files.run_lengths import mask_of_runs
from warehouse_sim.dataset.formats.bop.reader import read_model, require_size
from warehouse_sim.dataset.formats.bop.shards.archive import Extent, Keyed, ShardFolder
from warehouse_sim.dataset.formats.bop.shards.layout import image_key, shards_layout
from warehouse_sim.dataset.formats.bop.tables import BopRows, read_image
from warehouse_sim.dataset.manifest import Manifest, read_manifest
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS, require_split
from warehouse_sim.errors import DatasetError

_ROWS = ("camera.json", "gt.json", "gt_info.json")


class ShardsReader:
    """The folder ``bop_webdataset`` of a complete dataset.

    Args:
        root: Folder of the dataset.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self._manifest: Manifest = read_manifest(root)
        self._layout = shards_layout(root)
        self._keyed: dict[str, Keyed] = {}
        self._images: dict[str, list[ImageRecord]] = {}

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """The CAD geometries of the targets by obj_id."""
        return read_objects(self.root, partial(read_model, self._layout.bop))

    @property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Scene indices of each split."""
        return {name: self._manifest.splits[name] for name in SPLITS}

    @property
    def has_clean(self) -> bool:
        """Whether there are clean images beside those that were read."""
        return self._manifest.contents.clean

    def images(self, split: str) -> list[ImageRecord]:
        """Return the images of a split, by scene and image id.

        Raises:
            DatasetError: No such split, or a shard is missing or malformed.
        """
        require_split(self.root, split, self.splits)
        if split not in self._images:
            self._images[split] = [self._record(split, scene, image) for scene, image in self._split(split).numbers()]
        return self._images[split]

    def files(self, split: str) -> list[Path]:
        """Return the shards of a split and their table, sorted."""
        return self._split(split).files()

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image."""
        return self._colour(image, "rgb.png")

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth image: metres along the optical axis, 0 = no reading."""
        return self._metres(image, "depth.png")

    def clean_rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image as it was drawn, without errors of a camera."""
        return self._colour(image, "rgb_clean.png")

    def clean_depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth without errors of a sensor: metres, 0 = nothing there, or farther than the file can say."""
        return self._metres(image, "depth_clean.png")

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's visible pixels."""
        return self._mask(image, gt_index, "mask_visib.json")

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's whole amodal mask, as far as it lies in the image."""
        return self._mask(image, gt_index, "mask.json")

    def _colour(self, image: ImageRecord, kind: str) -> UInt8[np.ndarray, "h w 3"]:
        member = self._member(image, kind)
        return require_size(rgb_of_png(member.read(), member.where), image, kind)

    def _metres(self, image: ImageRecord, kind: str) -> Float32[np.ndarray, "h w"]:
        member = self._member(image, kind)
        steps = require_size(depth_of_png(member.read(), member.where), image, kind)
        return steps.astype(np.float32) * np.float32(image.depth_scale / 1000.0)

    def _mask(self, image: ImageRecord, gt_index: int, kind: str) -> Bool[np.ndarray, "h w"]:
        member = self._member(image, kind)
        found = parse_json(member.read(), member.where)
        runs = found.get(str(gt_index)) if isinstance(found, dict) else None
        return mask_of_runs(runs, (image.camera.height, image.camera.width), f"{member.where}: {gt_index}")

    def _member(self, image: ImageRecord, kind: str) -> Extent:
        return self._split(image.split).member((image.scene_id, image.image_id), kind)

    def _record(self, split: str, scene: int, image: int) -> ImageRecord:
        keyed = self._split(split)
        colour = keyed.member((scene, image), "rgb.png")
        members = [keyed.member((scene, image), kind) for kind in _ROWS]
        rows = BopRows(*((parse_json(member.read(), member.where), member.where) for member in members))
        return read_image(split, (scene, image), png_header_size_wh(colour.read(24), colour.where), rows)

    def _split(self, split: str) -> Keyed:
        """Return the shards of a split, which hold the images of the manifest and no other.

        Raises:
            DatasetError: They hold others.
        """
        if split not in self._keyed:
            folder, per_scene = self._layout.split(split), self._manifest.observations_per_scene
            wanted = {(scene, image) for scene in self.splits[split] for image in range(per_scene)}
            keyed: Keyed = ShardFolder(folder)
            found = set(keyed.numbers()) if wanted or folder.exists() else set()
            if found != wanted:
                name = image_key(*min(found ^ wanted))
                state = "is missing" if min(found ^ wanted) in wanted else "does not belong to the dataset"
                raise DatasetError(f"{folder}: image {name} {state}; copy or generate the dataset again")
            self._keyed[split] = keyed
        return self._keyed[split]
