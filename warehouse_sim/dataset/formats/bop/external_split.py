"""The images and labels of one split of a third-party BOP folder, scene by scene or image by image."""

from collections.abc import Collection
from functools import partial
from pathlib import Path

import numpy as np
from jaxtyping import Bool, UInt8

from warehouse_sim.dataset.files.extent import Extent
from warehouse_sim.dataset.files.image_io import (
    decode_any_depth,
    decode_any_mask,
    decode_any_rgb,
    image_size_wh,
)
from warehouse_sim.dataset.files.json_file import read_json, read_table
from warehouse_sim.dataset.files.png import is_rgb_png
from warehouse_sim.dataset.files.run_lengths import mask_of_runs
from warehouse_sim.dataset.formats.bop.external_image import ExternalRows, external_image
from warehouse_sim.dataset.formats.bop.shards.archive import ImagewiseFolder, Keyed, ShardFolder
from warehouse_sim.dataset.formats.bop.shards.layout import MEMBER, SHARD
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError

TABLE = "scene_{}.json"
_IMAGES = ("rgb", "gray")


def is_scene(path: Path) -> bool:
    """Return whether a folder is a scene."""
    return path.name.isdecimal() and (path / TABLE.format("camera")).is_file()


class ScenewiseSplit:
    """A folder of scenes.

    Args:
        root: The folder.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self._scenes = {int(path.name): path for path in filter(is_scene, root.iterdir())}

    @property
    def scene_ids(self) -> tuple[int, ...]:
        """Numbers of its scenes, ascending."""
        return tuple(sorted(self._scenes))

    def images(self, split: str, known: Collection[int]) -> list[ImageRecord]:
        """Return all images; labels of objects that are not ``known`` are left out.

        Raises:
            DatasetError: A table is malformed, or neither it nor a mask says where a target is in its image.
        """
        return [image for number in self.scene_ids for image in self._of_scene(split, number, known)]

    def files(self) -> list[Path]:
        """Return all files, sorted."""
        return [path for number in self.scene_ids for path in sorted(self._scenes[number].rglob("*"))]

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image; a grey one has three equal channels."""
        return decode_any_rgb(self._colour(image.scene_id, image.image_id))

    def rgb_file(self, image: ImageRecord) -> Path | None:
        """Return the file of the colour image where it is an 8-bit RGB image in PNG."""
        path = self._colour(image.scene_id, image.image_id)
        return path if is_rgb_png(path) else None

    def steps(self, image: ImageRecord) -> np.ndarray:
        """Read the depth image in its own steps, 0 = no reading."""
        return decode_any_depth(self._file(image.scene_id, "depth", image.image_id))

    def mask(self, kind: str, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"] | None:
        """Read a mask of the kind "mask" or "mask_visib"; None where there is none."""
        return self._mask(image.scene_id, image.image_id, kind, gt_index)

    def _of_scene(self, split: str, scene_id: int, known: Collection[int]) -> list[ImageRecord]:
        """Read the tables of a scene; images without labels have no targets."""
        path = {name: self._scenes[scene_id] / TABLE.format(name) for name in ("camera", "gt", "gt_info")}
        cameras, poses, infos = (read_table(file) if file.is_file() else {} for file in path.values())
        size_wh = image_size_wh(self._colour(scene_id, min(cameras))) if cameras else (1, 1)
        return [
            external_image(
                split,
                (scene_id, key),
                size_wh,
                ExternalRows(
                    camera,
                    poses.get(key),
                    infos.get(key),
                    partial(self._mask, scene_id, key),
                    f"{path['camera']}: {key}",
                    f"{path['gt']}: {key}",
                ),
                known,
            )
            for key, camera in cameras.items()
        ]

    def _file(self, scene_id: int, kind: str, image_id: int) -> Path:
        """Return the file of an image, whatever it ends with.

        Raises:
            DatasetError: There is none.
        """
        folder = self._scenes[scene_id] / kind
        found = sorted(folder.glob(f"{image_id:06d}.*"))
        if not found:
            raise DatasetError(f"{folder}: there is no image {image_id}; training and scoring need it")
        return found[0]

    def _colour(self, scene_id: int, image_id: int) -> Path:
        kind = next((name for name in _IMAGES if (self._scenes[scene_id] / name).is_dir()), _IMAGES[0])
        return self._file(scene_id, kind, image_id)

    def _mask(self, scene_id: int, image_id: int, kind: str, gt_index: int) -> Bool[np.ndarray, "h w"] | None:
        path = next(iter(sorted((self._scenes[scene_id] / kind).glob(f"{image_id:06d}_{gt_index:06d}.*"))), None)
        return None if path is None else decode_any_mask(path)


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
                sizes[key[0]] = image_size_wh(self._first(key, _COLOUR))
            images.append(self._image(split, key, sizes[key[0]], known))
        return images

    def files(self) -> list[Path]:
        """Return all files, sorted."""
        return self._keyed.files()

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image; a grey one has three equal channels."""
        return decode_any_rgb(self._first((image.scene_id, image.image_id), _COLOUR))

    def rgb_file(self, image: ImageRecord) -> Path | None:
        """Return the file of the colour image where it is an 8-bit RGB image in PNG; none of one in an archive."""
        member = self._first((image.scene_id, image.image_id), _COLOUR)
        return None if member.name or not is_rgb_png(member.path) else member.path

    def steps(self, image: ImageRecord) -> np.ndarray:
        """Read the depth image in its own steps, 0 = no reading."""
        return decode_any_depth(self._first((image.scene_id, image.image_id), _DEPTH))

    def mask(self, kind: str, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"] | None:
        """Read a mask of the kind "mask" or "mask_visib"; None where there is none."""
        key, size_hw = (image.scene_id, image.image_id), (image.camera.height, image.camera.width)
        return self._mask(key, size_hw, kind, gt_index)

    def _image(self, split: str, key: tuple[int, int], size_wh: tuple[int, int], known: Collection[int]) -> ImageRecord:
        camera = self._keyed.member(key, "camera.json")
        labels, infos = (self._keyed.find(key, f"{name}.json") for name in ("gt", "gt_info"))
        rows = ExternalRows(
            read_json(camera),
            None if labels is None else read_json(labels),
            None if infos is None else read_json(infos),
            partial(self._mask, key, size_wh[::-1]),
            camera.where,
            camera.where if labels is None else labels.where,
        )
        return external_image(split, key, size_wh, rows, known)

    def _mask(
        self, key: tuple[int, int], size_hw: tuple[int, int], kind: str, gt_index: int
    ) -> Bool[np.ndarray, "h w"] | None:
        member = self._keyed.find(key, f"{kind}.json")
        data = None if member is None else read_json(member)
        if member is None or not isinstance(data, dict) or data.get(str(gt_index)) is None:
            return None
        return mask_of_runs(data[str(gt_index)], size_hw, f"{member.where}: {gt_index}")

    def _first(self, key: tuple[int, int], kinds: tuple[str, ...]) -> Extent:
        found = next((member for kind in kinds if (member := self._keyed.find(key, kind)) is not None), None)
        if found is None:
            raise DatasetError(f"{self.root}: {key[0]:06d}_{key[1]:06d} has none of {', '.join(kinds)}")
        return found
