"""Images of a third-party BOP folder whose files bear their scene and image: imagewise, or in shards."""

from collections.abc import Collection
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, UInt8

from warehouse_sim.dataset.files.image_io import any_depth, any_rgb, any_size_wh
from warehouse_sim.dataset.files.json_file import parse_json
from warehouse_sim.dataset.files.png import is_rgb_png
from warehouse_sim.dataset.files.run_lengths import mask_of_runs
from warehouse_sim.dataset.formats.bop.external_image import ExternalRows, external_image
from warehouse_sim.dataset.formats.bop.shards.archive import Extent
from warehouse_sim.dataset.formats.bop.shards.keyed import ImagewiseFolder, Keyed, ShardFolder
from warehouse_sim.dataset.formats.bop.shards.layout import MEMBER, SHARD
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError

_COLOUR = ("rgb.png", "rgb.jpg", "gray.tiff", "gray.tif", "gray.png", "gray.jpg")
_DEPTH = ("depth.png", "depth.tiff", "depth.tif")


def keyed_folder(root: Path) -> Keyed | None:
    """Return the shards or the imagewise files of a folder, if it holds any."""
    names = [path.name for path in root.iterdir()]
    if any(map(SHARD.fullmatch, names)):
        return ShardFolder(root)
    if any(name.endswith(".camera.json") and MEMBER.fullmatch(name) for name in names):
        return ImagewiseFolder(root)
    return None


class KeyedSplit:
    """A folder of such images.

    Args:
        root: The folder.
        keyed: Its files.
    """

    def __init__(self, root: Path, keyed: Keyed) -> None:
        self.root, self._keyed = root, keyed

    @property
    def scene_ids(self) -> tuple[int, ...]:
        """Numbers of its scenes, ascending."""
        return tuple(sorted({scene for scene, _ in self._keyed.numbers()}))

    def images(self, split: str, known: Collection[int]) -> list[ImageRecord]:
        """Return all images; labels of objects that are not ``known`` are left out.

        Raises:
            DatasetError: A file is missing or malformed.
        """
        sizes: dict[int, tuple[int, int]] = {}
        images = []
        for key in self._keyed.numbers():
            if key[0] not in sizes:
                # All images of a scene are one camera's; a JPEG image says its size only when it is decoded.
                member = self._first(key, _COLOUR)
                sizes[key[0]] = any_size_wh(member.read(), member.where)
            images.append(self._image(split, key, sizes[key[0]], known))
        return images

    def files(self) -> list[Path]:
        """Return all files, sorted."""
        return self._keyed.files()

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image; a grey one has three equal channels."""
        member = self._first((image.scene_id, image.image_id), _COLOUR)
        return any_rgb(member.read(), member.where)

    def rgb_file(self, image: ImageRecord) -> Path | None:
        """Return the file of the colour image where it is an 8-bit RGB image in PNG; none of one in an archive."""
        member = self._first((image.scene_id, image.image_id), _COLOUR)
        return None if member.name or not is_rgb_png(member.path) else member.path

    def steps(self, image: ImageRecord) -> np.ndarray:
        """Read the depth image in its own steps, 0 = no reading."""
        member = self._first((image.scene_id, image.image_id), _DEPTH)
        return any_depth(member.read(), member.where)

    def mask(self, kind: str, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"] | None:
        """Read a mask of the kind "mask" or "mask_visib"; None where there is none."""
        size_hw = image.camera.height, image.camera.width
        return self._mask((image.scene_id, image.image_id), size_hw, kind, gt_index)

    def _image(self, split: str, key: tuple[int, int], size_wh: tuple[int, int], known: Collection[int]) -> ImageRecord:
        camera = self._keyed.member(key, "camera.json")
        labels = self._keyed.find(key, "gt.json")
        rows = ExternalRows(
            self._json(camera),
            self._json(labels),
            self._json(self._keyed.find(key, "gt_info.json")),
            partial(self._mask, key, size_wh[::-1]),
            camera.where,
            camera.where if labels is None else labels.where,
        )
        return external_image(split, key, size_wh, rows, known)

    def _mask(
        self, key: tuple[int, int], size_hw: tuple[int, int], kind: str, gt_index: int
    ) -> Bool[np.ndarray, "h w"] | None:
        member = self._keyed.find(key, f"{kind}.json")
        data = self._json(member)
        if member is None or not isinstance(data, dict) or data.get(str(gt_index)) is None:
            return None
        return mask_of_runs(data[str(gt_index)], size_hw, f"{member.where}: {gt_index}")

    def _json(self, member: Extent | None) -> Any:
        return None if member is None else parse_json(member.read(), member.where)

    def _first(self, key: tuple[int, int], kinds: tuple[str, ...]) -> Extent:
        found = next((member for kind in kinds if (member := self._keyed.find(key, kind)) is not None), None)
        if found is None:
            raise DatasetError(f"{self.root}: {key[0]:06d}_{key[1]:06d} has none of {', '.join(kinds)}")
        return found
