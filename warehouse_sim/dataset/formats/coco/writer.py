"""Write COCO: images and segment ids as they come, a part of each table a scene, the parts put together at the end."""

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.files.json_file import write_json
from warehouse_sim.dataset.files.png import encode_png
from warehouse_sim.dataset.formats.coco.labels import amodal_row, image_row, instance_row
from warehouse_sim.dataset.formats.coco.layout import (
    IMAGES,
    TABLES,
    CocoLayout,
    coco_layout,
    image_name,
    image_number,
)
from warehouse_sim.dataset.formats.coco.merge import merge_tables
from warehouse_sim.dataset.formats.coco.panoptic import id_colors, segments
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.output import make_folder, write_bytes, writing
from warehouse_sim.schema import ObjectModel, SceneSpec


class CocoWriter:
    """Write ``coco/{train,val,test}`` and ``coco/annotations``."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        self._manifest, self._layout = manifest, coco_layout(root)

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Make the folders, which are there even for splits without scenes."""
        for split in SPLITS:
            make_folder(self._layout.images(split))
            make_folder(self._layout.segments(split))

    def scene(self, scene: SceneSpec) -> "CocoSceneWriter":
        """Open a scene again."""
        split, index = self._manifest.split_of(scene.scene_index), scene.scene_index
        part = self._layout.part(index, IMAGES).parent
        with writing(part):
            if part.exists():
                shutil.rmtree(part)
            for folder in (self._layout.images(split), self._layout.segments(split)):
                for observation in range(self._manifest.observations_per_scene):
                    (folder / f"{image_name(index, observation)}.png").unlink(missing_ok=True)
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
        self._parts: dict[str, list[dict[str, Any]]] = {name: [] for name in (IMAGES, *TABLES)}

    def write(self, files: ObservationFiles) -> None:
        """Write the images of one observation and keep its labels.

        Raises:
            DatasetError: An instance id does not fit.
        """
        observation = files.observation
        index = observation.observation_index
        name, number = image_name(self._scene_index, index), image_number(self._manifest, self._scene_index, index)
        files.rgb.save(self._layout.images(self._split) / f"{name}.png")
        self._parts[IMAGES].append(image_row(observation, number, name))
        self._parts["instances"] += [instance_row(number, target) for target in files.targets]
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
