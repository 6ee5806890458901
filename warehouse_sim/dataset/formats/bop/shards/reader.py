"""Read the BOP shards of a dataset with a manifest: members by name, at their place in the archive."""

from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, UInt8

from warehouse_sim.dataset.files.extent import Extent
from warehouse_sim.dataset.files.image_io import decode_depth, decode_rgb, image_size_wh
from warehouse_sim.dataset.files.jpeg import decode_jpeg, jpeg_size_wh
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.run_lengths import mask_of_runs
from warehouse_sim.dataset.formats.bop.reader import OwnReader, camera_size_wh
from warehouse_sim.dataset.formats.bop.shards import shards_layout
from warehouse_sim.dataset.formats.bop.shards.archive import ShardFolder
from warehouse_sim.dataset.formats.bop.shards.coding import LOSSLESS, Coding
from warehouse_sim.dataset.formats.bop.tables import BopRows, read_image
from warehouse_sim.dataset.layout import observation_name
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError

_ROWS = ("camera.json", "gt.json", "gt_info.json")


class ShardsReader(OwnReader):
    """The folder ``bop_webdataset`` or ``bop_compact`` of a complete dataset.

    Args:
        root: Folder of the dataset.
        coding: Which of them.
    """

    def __init__(self, root: Path, coding: Coding = LOSSLESS) -> None:
        self._coding, self._layout = coding, shards_layout(root, coding.name)
        super().__init__(root, self._layout.bop)
        self._shards: dict[str, ShardFolder] = {}
        self._latest: dict[str, tuple[Extent, Any]] = {}

    def files(self, split: str) -> list[Path]:
        """Return the shards of a split and their table, sorted."""
        return self._split(split).files()

    def _read(self, split: str) -> list[ImageRecord]:
        return [self._record(split, scene, image) for scene, image in self._split(split).numbers()]

    def _colour(self, image: ImageRecord, kind: str) -> UInt8[np.ndarray, "h w 3"]:
        member = self._member(image, f"{kind}.{self._coding.colour}")
        return decode_jpeg(member) if self._coding.compact else decode_rgb(member)

    def _steps(self, image: ImageRecord, kind: str) -> np.ndarray:
        return decode_depth(self._member(image, f"{kind}.png"))

    def _mask(self, image: ImageRecord, gt_index: int, kind: str) -> Bool[np.ndarray, "h w"]:
        member = self._member(image, f"{kind}.json")
        # All masks of an image are in one member; who reads one mostly reads the next.
        where, found = self._latest.get(kind, (None, None))
        if where != member:
            found = read_json(member)
            self._latest[kind] = member, found
        runs = found.get(str(gt_index)) if isinstance(found, dict) else None
        return mask_of_runs(runs, (image.camera.height, image.camera.width), f"{member.where}: {gt_index}")

    def _member(self, image: ImageRecord, kind: str) -> Extent:
        return self._split(image.split).member((image.scene_id, image.image_id), kind)

    def _record(self, split: str, scene: int, image: int) -> ImageRecord:
        shards = self._split(split)
        members = [shards.member((scene, image), kind) for kind in _ROWS]
        rows = BopRows(*((read_json(member), member.where) for member in members))
        return read_image(split, (scene, image), self._size_wh(shards, (scene, image)), rows)

    def _size_wh(self, shards: ShardFolder, numbers: tuple[int, int]) -> tuple[int, int]:
        """Return width and height of an image (px): the colour's, or the rig's camera's where that is left out."""
        if "rgb" not in self._manifest.contents.outputs:
            return camera_size_wh(self._bop)
        colour = shards.member(numbers, f"rgb.{self._coding.colour}")
        return jpeg_size_wh(colour) if self._coding.compact else image_size_wh(colour)

    def _split(self, split: str) -> ShardFolder:
        """Return the shards of a split, which hold the images of the manifest and no other.

        Raises:
            DatasetError: They hold others.
        """
        if split not in self._shards:
            folder, per_scene = self._layout.split(split), self._manifest.observations_per_scene
            wanted = {(scene, image) for scene in self.splits[split] for image in range(per_scene)}
            shards = ShardFolder(folder)
            found = set(shards.numbers()) if wanted or folder.exists() else set()
            if found != wanted:
                name = observation_name(*min(found ^ wanted))
                state = "is missing" if min(found ^ wanted) in wanted else "does not belong to the dataset"
                raise DatasetError(f"{folder}: image {name} {state}; copy or generate the dataset again")
            self._shards[split] = shards
        return self._shards[split]
