"""Read a COCO folder, ours or third-party: images, classes, boxes and masks; poses and cameras where it has them."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import (
    FRACTIONS,
    PIXELS,
    WHOLE,
    Span,
    read_lens,
    read_transform,
    take,
    take_if_given,
    take_numbers,
)
from warehouse_sim.dataset.files.run_lengths import mask_of_runs
from warehouse_sim.dataset.formats.reader_base import (
    Box,
    ImagesOnly,
    box_mask,
    guessed_camera,
    inside,
    shapeless,
)
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import NO_POSE, ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera

_TABLE = re.compile(r"instances_([A-Za-z]\w*)\.json")
_EXPORTED = "_annotations.coco.json"
"""Where annotation services put the table of a split: beside its images."""
_ALSO = {"valid": "val", "validation": "val"}
_NUMBERS = Span(0, 2**53)
_PLACES = Span(-1e6, 1e6)
_AREAS = Span(0, 2**31)


def find_tables(root: Path) -> dict[str, Path]:
    """Return the table of instances of each split: "train", "val", "test", without the year if that is unique."""
    folder = root / "annotations"
    listed = sorted(folder.iterdir()) if folder.is_dir() else []
    by_name = {match[1]: path for path in listed if (match := _TABLE.fullmatch(path.name))}
    by_name = {name: path for name, path in by_name.items() if not name.startswith("amodal_")}
    if not by_name and root.is_dir():
        by_name = {path.parent.name: path for path in sorted(root.glob(f"*/{_EXPORTED}"))}
    short = {name: _ALSO.get(name.rstrip("0123456789_"), name.rstrip("0123456789_")) for name in by_name}
    unique = {name for name in short if list(short.values()).count(short[name]) == 1}
    return {(short[name] if name in unique else name): path for name, path in by_name.items()}


@dataclass(frozen=True, eq=False)
class CocoTable:
    """The entries of one split."""

    images: list[ImageRecord]
    """By scene and image id."""
    files: dict[tuple[int, int], str]
    """Name of each image's file by scene and image id."""
    annotations: dict[tuple[int, int], list[dict[str, Any]]]
    """Entries of each image's targets, in order."""
    categories: dict[int, str]


def read_table(path: Path, split: str, scene_id: int, own_objects: bool) -> CocoTable:
    """Read a table of instances.

    Args:
        path: The file.
        split: Its split.
        scene_id: Scene of the images where the table has no scenes.
        own_objects: Whether targets are objects by ``obj_id``, where it is given, not by category.

    Raises:
        DatasetError: The file is missing, malformed, or its entries name what it does not hold.
    """
    data, where = read_json(path), str(path)
    categories = {
        take(row, "id", int, f"{where}: categories[{i}]", WHOLE): take(row, "name", str, f"{where}: categories[{i}]")
        for i, row in enumerate(take(data, "categories", list, where))
    }
    by_image: dict[int, list[tuple[str, dict[str, Any]]]] = {}
    for i, row in enumerate(take(data, "annotations", list, where)):
        here = f"{where}: annotations[{i}]"
        number = take(row, "image_id", int, here, _NUMBERS)
        # A crowd is no target; our own mark what is hardly visible in this way.
        if not take_if_given(row, "iscrowd", int, here) or "instance_id" in row:
            by_image.setdefault(number, []).append((here, row))
    table = CocoTable([], {}, {}, categories)
    for i, row in enumerate(take(data, "images", list, where)):
        _add_image(table, row, f"{where}: images[{i}]", split, scene_id, by_image, own_objects)
    if by_image:
        here, row = next(iter(by_image.values()))[0]
        raise DatasetError(f"{here}: image_id {row['image_id']} is not among the images, or two have that number")
    table.images.sort(key=lambda image: (image.scene_id, image.image_id))
    return table


def _add_image(
    table: CocoTable,
    row: Any,
    where: str,
    split: str,
    scene_id: int,
    by_image: dict[int, list[tuple[str, dict[str, Any]]]],
    own_objects: bool,
) -> None:
    number = take(row, "id", int, where, _NUMBERS)
    rows = by_image.pop(number, [])
    scene = take_if_given(row, "scene_id", int, where, WHOLE)
    observation = take_if_given(row, "observation", int, where, WHOLE)
    ours = scene is not None and observation is not None
    key = (scene, observation) if scene is not None and observation is not None else (scene_id, number)
    if key in table.files:
        raise DatasetError(f"{where}: another image has the same number {number}")
    pose = take_if_given(row, "T_world_camera", list, where)
    targets = [_target(i, item, here, table.categories, own_objects and ours) for i, (here, item) in enumerate(rows)]
    table.files[key] = take(row, "file_name", str, where)
    table.annotations[key] = [item for _, item in rows]
    table.images.append(
        ImageRecord(
            split=split,
            scene_id=key[0],
            image_id=key[1],
            camera=_camera(row, where),
            T_world_camera=np.eye(4) if pose is None else read_transform(pose, where),
            depth_scale=1.0,
            targets=tuple(targets),
            calibrated="K" in row,
        )
    )


def _camera(row: Any, where: str) -> PinholeCamera:
    width, height = (take(row, key, int, where, PIXELS) for key in ("width", "height"))
    if "K" not in row:
        return guessed_camera(width, height)
    rows = [take_numbers({"K": item}, "K", 3, where, _PLACES) for item in take(row, "K", list, where)]
    if len(rows) != 3 or rows[0][1] or rows[1][0] or rows[2].tolist() != [0.0, 0.0, 1.0]:
        raise DatasetError(f"{where}: K must be a pinhole camera without skew")
    (fx, _, cx), (_, fy, cy), _ = (item.tolist() for item in rows)
    try:
        camera = PinholeCamera(width, height, fx, fy, cx, cy, read_lens(row, where))
        camera.require_clear_lens()
    except ValueError as problem:
        raise DatasetError(f"{where}: K is no camera ({problem})") from problem
    return camera


def _target(index: int, row: Any, where: str, categories: dict[int, str], own_object: bool) -> TargetRecord:
    number = take(row, "category_id", int, where, WHOLE)
    if number not in categories:
        raise DatasetError(f"{where}: category_id {number} is not among the categories {sorted(categories)}")
    box = _box(row, "bbox", where)
    width, height = box[2] - box[0] + 1, box[3] - box[1] + 1
    area = take_if_given(row, "area", float, where, _AREAS)
    seen = round(width * height if area is None else area)
    pose = take_if_given(row, "T_camera_object", list, where)
    valid = take_if_given(row, "pixels_valid", int, where, WHOLE)
    fraction = take_if_given(row, "visible_fraction", float, where, FRACTIONS)
    return TargetRecord(
        gt_index=index,
        obj_id=take(row, "obj_id", int, where, WHOLE) if own_object else number,
        instance_id=take_if_given(row, "instance_id", int, where, WHOLE) or 0,
        T_camera_object=NO_POSE if pose is None else read_transform(pose, where),
        visible_fraction=1.0 if fraction is None else fraction,
        pixels_visible=seen,
        box_visible_xyxy=box,
        box_amodal_xyxy=_box(row, "bbox_amodal", where) if "bbox_amodal" in row else box,
        pixels_valid=seen if valid is None else valid,
        pixels_all=take_if_given(row, "pixels_all", int, where, WHOLE) or max(seen, 1),
    )


def _box(row: Any, key: str, where: str) -> Box:
    """Read COCO's left, top, width and height as inclusive corners (px)."""
    left, top, width, height = take_numbers(row, key, 4, where, _PLACES).tolist()
    if width < 0 or height < 0:
        raise DatasetError(f"{where}: {key} must have a width and a height >= 0, found {width} and {height}")
    return left, top, left + max(width - 1, 0), top + max(height - 1, 0)


class CocoReader(ImagesOnly):
    """A folder with tables of instances.

    Args:
        root: The COCO folder.
        objects: The objects of the dataset that it belongs to; None takes each category for one.
    """

    def __init__(self, root: Path, objects: Mapping[int, ObjectInfo] | None = None) -> None:
        self._paths = find_tables(root)
        super().__init__(root, self._paths)
        self._given = objects
        self._tables: dict[str, CocoTable] = {}
        self._whole: dict[str, dict[int, Any]] = {}

    @cached_property
    def objects(self) -> Mapping[int, ObjectInfo]:
        """The objects of the dataset, or its categories, of whose shape nothing is known."""
        if self._given is not None:
            return self._given
        names = {number: name for split in self._paths for number, name in self._table(split).categories.items()}
        return {number: shapeless(number, name, self.root) for number, name in sorted(names.items())}

    @cached_property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Scene numbers of each split; a third-party split is one scene."""
        return {split: tuple(sorted({image.scene_id for image in self._table(split).images})) for split in self._paths}

    def _read(self, split: str) -> list[ImageRecord]:
        return self._table(split).images

    def files(self, split: str) -> list[Path]:
        """Return the table and the images of a split, sorted."""
        return sorted([self._paths[split], *(self._file(image) for image in self.images(split))])

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target; its box where there is none."""
        row = self._table(image.split).annotations[image.scene_id, image.image_id][gt_index]
        return self._mask(row.get("segmentation"), image, gt_index)

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's whole amodal mask in the image; the visible mask where none is stored."""
        row = self._table(image.split).annotations[image.scene_id, image.image_id][gt_index]
        whole = self._amodal(image.split).get(row.get("id", 0))
        return self.mask_visible(image, gt_index) if whole is None else self._mask(whole, image, gt_index)

    def _mask(self, segmentation: Any, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        where = f"{self._paths[image.split]}: image {image.image_id}, target {gt_index}"
        shape = image.camera.height, image.camera.width
        if not segmentation:
            return box_mask(image.targets[gt_index].box_visible_xyxy, image.camera, halves_up=True)
        return (
            mask_of_runs(segmentation, shape, where)
            if isinstance(segmentation, dict)
            else polygon_mask(segmentation, shape, where)
        )

    def _table(self, split: str) -> CocoTable:
        if split not in self._tables:
            number = list(self._paths).index(split)
            self._tables[split] = read_table(self._paths[split], split, number, self._given is not None)
        return self._tables[split]

    def _amodal(self, split: str) -> dict[int, Any]:
        """Return the segmentation of whole amodal masks by number of the annotation."""
        path = self._paths[split]
        path = path.with_name(path.name.replace("instances_", "instances_amodal_", 1))
        if split not in self._whole:
            rows = take(read_json(path), "annotations", list, str(path)) if path.is_file() else []
            self._whole[split] = {row["id"]: row.get("segmentation") for row in rows if isinstance(row, dict)}
        return self._whole[split]

    def _file(self, image: ImageRecord, kind: str = "rgb") -> Path:
        """Return the file of an image, wherever others keep it.

        Raises:
            DatasetError: Its name leads out of the dataset, or there is none.
        """
        table = self._paths[image.split]
        name = self._table(image.split).files[image.scene_id, image.image_id]
        raw = table.stem.removeprefix("instances_")
        folders = [
            self.root / raw,
            self.root / "images" / raw,
            self.root / image.split,
            self.root / "images",
            self.root,
        ]
        if table.parent.name != "annotations":
            folders.insert(0, table.parent)
        for folder in folders:
            path = inside(folder, name, f"{table}: file_name")
            if path.is_file():
                return path
        raise DatasetError(f"{table}: there is no image {name!r} in {folders[0]} or the folders beside it")


def polygon_mask(polygons: Any, shape: tuple[int, int], where: str) -> Bool[np.ndarray, "h w"]:
    """Return the pixels of COCO's polygons, as pycocotools counts them.

    Raises:
        DatasetError: They are no polygons.
    """
    from pycocotools import mask as coco_mask

    height, width = shape
    flat = polygons if isinstance(polygons, list) else []
    for corners in flat:
        numbers = isinstance(corners, list) and all(type(value) in (int, float) for value in corners)
        if not numbers or len(corners) < 6 or len(corners) % 2:
            raise DatasetError(f"{where}: a polygon must be a list of x, y of three corners at least")
    if not flat:
        raise DatasetError(f"{where}: segmentation must be polygons or run lengths, found {type(polygons).__name__}")
    # What leaves the image is cut, and no number is larger than it.
    bounded = [np.clip(np.reshape(item, (-1, 2)), 0, [width, height]).ravel().tolist() for item in flat]
    mask: Bool[np.ndarray, "h w"] = coco_mask.decode(
        coco_mask.merge(coco_mask.frPyObjects(bounded, height, width))
    ).astype(bool)
    return mask
