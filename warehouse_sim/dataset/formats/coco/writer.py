"""Write COCO: images and segment ids as they come, a part of each table a scene, the parts put together at the end.

What COCO's tools do not know of an entry, they pass over. Entries name their class as ``category``; its number takes
that place when the tables are put together.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Int32, UInt8
from scipy.ndimage import find_objects

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.files.plain import lens_row, take
from warehouse_sim.dataset.files.png import encode_png
from warehouse_sim.dataset.files.run_lengths import compressed
from warehouse_sim.dataset.formats.built_in import WriterBase, remove_file, remove_folder
from warehouse_sim.dataset.formats.coco import (
    IMAGES,
    CocoLayout,
    Table,
    coco_layout,
    image_number,
    tables_of,
)
from warehouse_sim.dataset.formats.observation_files import VISIBLE_ENOUGH, LabelledTarget, ObservationFiles, box_xywh
from warehouse_sim.dataset.layout import observation_name
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.output import make_folder, write_bytes, write_pieces
from warehouse_sim.schema import ObjectModel, Observation, SceneSpec
from warehouse_sim.schema.classes import is_stuff, kind_of, numbered

VOID = 0
_MOST = 2**24 - 1


def segments(
    instance_mask: Int32[np.ndarray, "h w"], class_of: Mapping[int, str], where: str
) -> tuple[Int32[np.ndarray, "h w"], list[dict[str, Any]]]:
    """Return the image of segment ids and an entry of ``segments_info`` for each, in order of the ids.

    A thing's segment has its instance id, that of stuff the smallest instance id of its class in the image.

    Args:
        instance_mask: Instance by pixel, 0 = background.
        class_of: Class of each instance; pixels of an id without a class are void.
        where: Format and observation, for the message.

    Raises:
        DatasetError: An id does not fit into the three channels of the image.
    """
    lowest, highest = int(instance_mask.min()), int(instance_mask.max())
    if lowest < 0 or highest > _MOST:
        raise DatasetError(f"{where}: instance id {lowest if lowest < 0 else highest} must be 0 to {_MOST}")
    present = np.flatnonzero(np.bincount(instance_mask.ravel()))
    segment_of = np.zeros(highest + 1, dtype=np.int32)
    first_of: dict[str, int] = {}
    for number in (int(item) for item in present if int(item) in class_of and item > 0):
        name = class_of[number]
        segment_of[number] = first_of.setdefault(name, number) if is_stuff(name) else number
    image = segment_of[instance_mask]
    return image, [_row(number, class_of[number], area, box) for number, area, box in _measured(image)]


def id_colors(image: Int32[np.ndarray, "h w"]) -> UInt8[np.ndarray, "h w 3"]:
    """Return segment ids as colours: id = R + 256 G + 256^2 B."""
    return np.stack([image & 255, (image >> 8) & 255, image >> 16], axis=-1).astype(np.uint8)


def _measured(image: Int32[np.ndarray, "h w"]) -> list[tuple[int, int, list[int]]]:
    """Return id, pixels and COCO's box (px) of each segment."""
    counts = np.bincount(image.ravel())
    counts[VOID] = 0
    numbers = np.flatnonzero(counts)
    place = np.zeros(len(counts), dtype=np.int32)
    place[numbers] = np.arange(1, len(numbers) + 1)
    return [
        (number, int(counts[number]), [columns.start, rows.start, columns.stop - columns.start, rows.stop - rows.start])
        for number, (rows, columns) in zip(numbers.tolist(), find_objects(place[image]), strict=True)
    ]


def _row(number: int, name: str, area: int, box: list[int]) -> dict[str, Any]:
    return {"id": number, "category": name, "area": area, "bbox": box, "iscrowd": 0}


def image_row(observation: Observation, number: int, name: str) -> dict[str, Any]:
    """Return an entry of ``images``, with the camera beside what COCO requires; metres."""
    camera = observation.camera
    row = {
        "id": number,
        "file_name": f"{name}.png",
        "width": camera.width,
        "height": camera.height,
        "scene_id": observation.scene_index,
        "observation": observation.observation_index,
        "K": camera.K,
        **lens_row(camera),
        "T_world_camera": observation.T_world_camera,
    }
    lux = observation.conditions.floor_lux
    return to_mapping(row if lux is None else row | {"floor_lux": lux})


def instance_row(image_number: int, target: LabelledTarget) -> dict[str, Any]:
    """Return an annotation of the visible part of a target: its mask, its box, its area."""
    annotation = target.annotation
    row = {
        **_common(image_number, target),
        "segmentation": compressed(target.runs_visible),
        "bbox": box_xywh(target.box_visible_xyxy, extra=1),
        "area": annotation.pixels_visible,
        "bbox_amodal": box_xywh(annotation.box_amodal_xyxy, extra=1),
        "pixels_all": annotation.pixels_all,
        "pixels_valid": annotation.pixels_valid,
        # Third-party masks may have no pose.
        **({"T_camera_object": annotation.T_camera_object} if np.isfinite(annotation.T_camera_object).all() else {}),
    }
    lux = annotation.illuminance
    return to_mapping(row if lux is None else row | {"lux": lux})


def amodal_row(image_number: int, target: LabelledTarget) -> dict[str, Any]:
    """Return an annotation of the whole amodal mask of a target as far as it lies in the image.

    ``bbox_uncut`` is the box of the amodal mask wherever it lies.
    """
    annotation = target.annotation
    box = mask_box_xyxy(target.mask)
    assert box is not None
    row = {
        **_common(image_number, target),
        "segmentation": compressed(target.runs),
        "bbox": box_xywh(box, extra=1),
        "area": annotation.pixels_in_image,
        "bbox_uncut": box_xywh(annotation.box_amodal_xyxy, extra=1),
        "pixels_all": annotation.pixels_all,
    }
    return to_mapping(row)


def _common(image_number: int, target: LabelledTarget) -> dict[str, Any]:
    annotation = target.annotation
    # COCO's evaluation overwrites "ignore" with "iscrowd", so that both say it.
    ignored = int(annotation.visible_fraction < VISIBLE_ENOUGH)
    return {
        "image_id": image_number,
        "category": annotation.class_name,
        "iscrowd": ignored,
        "ignore": ignored,
        "instance_id": annotation.instance_id,
        "obj_id": annotation.obj_id,
        "visible_fraction": annotation.visible_fraction,
    }


_INFO = {
    "instances": "visible masks, boxes and areas of the targets of synthetic warehouse scenes",
    "instances_amodal": "whole amodal masks of the targets as far as they lie in the image, and their boxes",
    "panoptic": "every visible object of synthetic warehouse scenes; what lies behind them all is void",
}


def merge_tables(layout: CocoLayout, manifest: Manifest) -> None:
    """Write all tables of all splits.

    Annotations are numbered from 1 through train, val and test, in order of scene, image and target; the same target
    has the same number as an instance and as an amodal one.

    Raises:
        DatasetError: The part of a scene is missing or malformed.
    """
    make_folder(layout.annotations)
    for name in tables_of(manifest.contents):
        numbers = numbered(_classes(layout, manifest, name))
        first = 1
        for split in SPLITS:
            pieces = _Pieces(layout, name, numbers, manifest.splits[split], first)
            write_pieces(layout.table(name, split), pieces)
            first = pieces.next_number


class _Pieces:
    """The lines of one table; what it hands out last says which number is free then."""

    def __init__(
        self, layout: CocoLayout, name: Table, numbers: dict[str, int], scenes: tuple[int, ...], first: int
    ) -> None:
        self._layout, self._name, self._numbers, self._scenes = layout, name, numbers, scenes
        self.next_number = first

    def __iter__(self) -> Iterator[bytes]:
        """Yield the file piece by piece."""
        panoptic = self._name == "panoptic"
        categories = [_category(name, number, panoptic) for name, number in self._numbers.items()]
        yield b'{\n"info": ' + _line({"description": _INFO[self._name], "version": "1.0"})
        yield b',\n"licenses": [],\n"categories": ' + _line(categories) + b',\n"images": ['
        yield from _listed(row for scene in self._scenes for row in _part(self._layout, scene, IMAGES))
        yield b'],\n"annotations": ['
        yield from _listed(self._annotation(row) for scene in self._scenes for row in self._rows(scene))
        yield b"]\n}\n"

    def _rows(self, scene: int) -> list[dict[str, Any]]:
        return _part(self._layout, scene, self._name)

    def _annotation(self, row: dict[str, Any]) -> dict[str, Any]:
        """Return an entry with numbers for names."""
        if self._name == "panoptic":
            return row | {"segments_info": [self._numbered(item) for item in row["segments_info"]]}
        self.next_number += 1
        return {"id": self.next_number - 1} | self._numbered(row)

    def _numbered(self, row: dict[str, Any]) -> dict[str, Any]:
        number = self._numbers[row["category"]]
        return {("category_id" if key == "category" else key): row[key] for key in row} | {"category_id": number}


def _classes(layout: CocoLayout, manifest: Manifest, name: Table) -> set[str]:
    """Return the classes of a table: the targets', and in the panoptic one all that is seen."""
    found = set(manifest.targets)
    for scene in manifest.scene_indices:
        where = str(layout.part(scene, name))
        for row in _part(layout, scene, name):
            items = take(row, "segments_info", list, where) if name == "panoptic" else [row]
            found |= {take(item, "category", str, where) for item in items}
    return found


def _category(name: str, number: int, panoptic: bool) -> dict[str, Any]:
    """Return an entry of ``categories``."""
    row = {"id": number, "name": name, "supercategory": kind_of(name)}
    return row | {"isthing": int(not is_stuff(name))} if panoptic else row


def _part(layout: CocoLayout, scene: int, name: str) -> list[dict[str, Any]]:
    path = layout.part(scene, name)
    if not path.is_file():
        raise DatasetError(f"{path}: is missing; remove the record of scene {scene} and go on with --resume")
    rows = read_json(path)
    return take({"rows": rows}, "rows", list, str(path))


def _listed(rows: Iterator[dict[str, Any]]) -> Iterator[bytes]:
    before = b"\n"
    for row in rows:
        yield before + _line(row)
        before = b",\n"


def _line(data: Any) -> bytes:
    return json.dumps(data, allow_nan=False).encode("ascii")


class CocoWriter(WriterBase):
    """Write ``coco/{train,val,test}`` and ``coco/annotations``."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        super().__init__(root, manifest)
        self._layout = coco_layout(root)

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Make the folders, which are there even for splits without scenes."""
        for split in SPLITS:
            make_folder(self._layout.images(split))
            make_folder(self._layout.segments(split))

    def scene(self, scene: SceneSpec) -> "CocoSceneWriter":
        """Open a scene again."""
        split, index = self._manifest.split_of(scene.scene_index), scene.scene_index
        remove_folder(self._layout.part(index, IMAGES).parent)
        for folder in (self._layout.images(split), self._layout.segments(split)):
            for observation in range(self._manifest.observations_per_scene):
                remove_file(folder / f"{observation_name(index, observation)}.png")
        class_of = {item.instance_id: scene.model_of(item).class_name for item in scene.instances}
        return CocoSceneWriter(self._layout, self._manifest, scene.scene_index, class_of)

    def finish(self) -> None:
        """Put the parts of all scenes together; they stay, so that a scene can be regenerated."""
        merge_tables(self._layout, self._manifest)


class CocoSceneWriter:
    """Write one scene: its images as they come, then its part of each table."""

    def __init__(self, layout: CocoLayout, manifest: Manifest, scene_index: int, class_of: Mapping[int, str]) -> None:
        self._layout, self._manifest = layout, manifest
        self._split, self._scene_index = manifest.split_of(scene_index), scene_index
        self._class_of = class_of
        self._parts: dict[str, list[dict[str, Any]]] = {name: [] for name in (IMAGES, *tables_of(manifest.contents))}

    def write(self, files: ObservationFiles) -> None:
        """Write the images of one observation and keep its labels.

        Raises:
            DatasetError: An instance id does not fit.
        """
        observation = files.observation
        index = observation.observation_index
        name, number = (
            observation_name(self._scene_index, index),
            image_number(self._manifest, self._scene_index, index),
        )
        files.rgb.save(self._layout.images(self._split) / f"{name}.png")
        self._parts[IMAGES].append(image_row(observation, number, name))
        self._parts["instances"] += [instance_row(number, target) for target in files.targets]
        if "instances_amodal" in self._parts:
            self._parts["instances_amodal"] += [amodal_row(number, target) for target in files.targets]
        # A label names the class also where the scene does not tell of the object.
        class_of = {**self._class_of, **{item.instance_id: item.class_name for item in observation.annotations}}
        where = f"COCO, scene {self._scene_index}, observation {index}"
        image, rows = segments(observation.buffers.instance_mask, class_of, where)
        write_bytes(self._layout.segments(self._split) / f"{name}.png", encode_png(id_colors(image), "up"))
        self._parts["panoptic"].append({"image_id": number, "file_name": f"{name}.png", "segments_info": rows})

    def finish(self) -> None:
        """Write the scene's parts."""
        make_folder(self._layout.part(self._scene_index, IMAGES).parent)
        for name, rows in self._parts.items():
            write_json(self._layout.part(self._scene_index, name), rows)
