"""Write COCO: images and segment ids as they come, a part of each table a scene, the parts put together at the end."""

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.files.plain import take
from warehouse_sim.dataset.files.png import encode_png
from warehouse_sim.dataset.formats.built_in import WriterBase, remove_file, remove_folder
from warehouse_sim.dataset.formats.coco import (
    IMAGES,
    CocoLayout,
    Table,
    coco_layout,
    image_number,
    tables_of,
)
from warehouse_sim.dataset.formats.coco.labels import amodal_row, id_colors, image_row, instance_row, segments
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.layout import observation_name
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.output import make_folder, write_bytes, write_pieces
from warehouse_sim.schema import ObjectModel, SceneSpec
from warehouse_sim.schema.classes import is_stuff, kind_of, numbered

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
