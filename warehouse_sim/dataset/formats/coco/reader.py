"""Read a COCO folder, ours or that of others: images, classes, boxes and masks; poses and cameras where it has them."""

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, UInt8

from warehouse_sim.dataset.files.image_io import decode_any_rgb
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import take
from warehouse_sim.dataset.files.run_lengths import mask_of_runs
from warehouse_sim.dataset.formats.bop.reader import require_size
from warehouse_sim.dataset.formats.coco.tables import CocoTable, find_tables, read_table
from warehouse_sim.dataset.formats.images_only import ImagesOnly, box_mask, inside, require_split, shapeless
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError


class CocoReader(ImagesOnly):
    """A folder with tables of instances.

    Args:
        root: The COCO folder.
        objects: The objects of the dataset that it belongs to; None takes each category for one.
    """

    def __init__(self, root: Path, objects: Mapping[int, ObjectInfo] | None = None) -> None:
        super().__init__(root)
        self._given = objects
        self._paths = find_tables(root)
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
        """Scene numbers of each split; a split of others is one scene."""
        return {split: tuple(sorted({image.scene_id for image in self._table(split).images})) for split in self._paths}

    def images(self, split: str) -> list[ImageRecord]:
        """Return the images of a split, by scene and image id.

        Raises:
            DatasetError: No such split, or its table is missing or malformed.
        """
        require_split(self._paths, split, self.root)
        return self._table(split).images

    def files(self, split: str) -> list[Path]:
        """Return the table and the images of a split, sorted."""
        return sorted([self._paths[split], *(self._file(image) for image in self.images(split))])

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image; a grey one has three equal channels."""
        return require_size(decode_any_rgb(self._file(image)), image, "the image")

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
            return box_mask(image.targets[gt_index].box_visible_xyxy, image.camera)
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

    def _file(self, image: ImageRecord) -> Path:
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
