"""The images and labels of one split of a third-party BOP folder: rows may be short, masks may be missing."""

import logging
from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

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
from warehouse_sim.dataset.files.png import is_rgb_png
from warehouse_sim.dataset.files.run_lengths import mask_of_runs
from warehouse_sim.dataset.formats.bop.shards import MEMBER, SHARD
from warehouse_sim.dataset.formats.bop.shards.archive import ImagewiseFolder, Keyed, ShardFolder
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


TABLE = "scene_{}.json"
_TABLES = ("camera", "gt", "gt_info")
_IMAGES = ("rgb", "gray")


def is_scene(path: Path) -> bool:
    """Return whether a folder is a scene: one of its tables says so, all others may be lost."""
    return path.name.isdecimal() and any((path / TABLE.format(name)).is_file() for name in _TABLES)


class ScenewiseSplit:
    """A folder of scenes.

    Args:
        root: The folder.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self._scenes = {int(path.name): path for path in root.iterdir() if path.name.isdecimal() and path.is_dir()}

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
        """Read the tables of a scene; images without labels have no targets.

        Raises:
            DatasetError: A table is malformed, or missing: that of cameras, or that of labels where they have infos.
        """
        path = {name: self._scenes[scene_id] / TABLE.format(name) for name in _TABLES}
        for table in (path["camera"], *([path["gt"]] if path["gt_info"].is_file() else [])):
            if not table.is_file():
                raise DatasetError(f"{table}: is missing; copy the dataset again")
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
