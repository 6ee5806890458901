"""Read the BOP shards of a dataset with a manifest: members by name, at their place in the archive."""

from pathlib import Path

import numpy as np
from jaxtyping import Bool, UInt8

from warehouse_sim.dataset.files.extent import Extent
from warehouse_sim.dataset.files.image_io import decode_depth, decode_rgb, image_size_wh
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.run_lengths import mask_of_runs
from warehouse_sim.dataset.formats.bop.reader import OwnReader
from warehouse_sim.dataset.formats.bop.shards.archive import ShardFolder
from warehouse_sim.dataset.formats.bop.shards.layout import shards_layout
from warehouse_sim.dataset.formats.bop.tables import BopRows, read_image
from warehouse_sim.dataset.layout import observation_name
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError

_ROWS = ("camera.json", "gt.json", "gt_info.json")


class ShardsReader(OwnReader):
    """The folder ``bop_webdataset`` of a complete dataset.

    Args:
        root: Folder of the dataset.
    """

    def __init__(self, root: Path) -> None:
        self._layout = shards_layout(root)
        super().__init__(root, self._layout.bop)
        self._shards: dict[str, ShardFolder] = {}

    def files(self, split: str) -> list[Path]:
        """Return the shards of a split and their table, sorted."""
        return self._split(split).files()

    def _read(self, split: str) -> list[ImageRecord]:
        return [self._record(split, scene, image) for scene, image in self._split(split).numbers()]

    def _colour(self, image: ImageRecord, kind: str) -> UInt8[np.ndarray, "h w 3"]:
        return decode_rgb(self._member(image, f"{kind}.png"))

    def _steps(self, image: ImageRecord, kind: str) -> np.ndarray:
        return decode_depth(self._member(image, f"{kind}.png"))

    def _mask(self, image: ImageRecord, gt_index: int, kind: str) -> Bool[np.ndarray, "h w"]:
        member = self._member(image, f"{kind}.json")
        found = read_json(member)
        runs = found.get(str(gt_index)) if isinstance(found, dict) else None
        return mask_of_runs(runs, (image.camera.height, image.camera.width), f"{member.where}: {gt_index}")

    def _member(self, image: ImageRecord, kind: str) -> Extent:
        return self._split(image.split).member((image.scene_id, image.image_id), kind)

    def _record(self, split: str, scene: int, image: int) -> ImageRecord:
        shards = self._split(split)
        colour = shards.member((scene, image), "rgb.png")
        members = [shards.member((scene, image), kind) for kind in _ROWS]
        rows = BopRows(*((read_json(member), member.where) for member in members))
        return read_image(split, (scene, image), image_size_wh(colour), rows)

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
