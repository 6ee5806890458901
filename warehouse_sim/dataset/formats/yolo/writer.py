"""Write YOLO: a data set a task, an image and a label file an observation each."""

from collections.abc import Sequence
from functools import cached_property, partial
from typing import Any

import yaml

from warehouse_sim.dataset.formats.built_in import EachWriter, WriterBase, remove_file
from warehouse_sim.dataset.formats.observation_files import LabelledTarget, ObservationFiles
from warehouse_sim.dataset.formats.yolo import TASKS, Task, YoloLayout, yolo_layout
from warehouse_sim.dataset.formats.yolo.polygons import mask_polygon
from warehouse_sim.dataset.formats.yolo.rows import (
    box_row,
    corner_row,
    key_points,
    label_file,
    mirrored,
    oriented_box,
    point_row,
    points_of,
)
from warehouse_sim.dataset.layout import observation_name
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import ObjectModel, SceneSpec
from warehouse_sim.schema.classes import numbered


class YoloWriter(WriterBase):
    """Write ``yolo/{detect,segment,pose,obb}``; no key points where no object of the dataset has pockets."""

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Make the folders and the descriptions."""
        for task, layout in self._layouts.items():
            for split in SPLITS:
                make_folder(layout.images(split))
                make_folder(layout.labels(split))
            write_bytes(layout.data, self._description(task).encode("utf-8"), durable=True)

    def scene(self, scene: SceneSpec) -> EachWriter:
        """Open a scene again."""
        split = self._manifest.split_of(scene.scene_index)
        for layout in self._layouts.values():
            for index in range(self._manifest.observations_per_scene):
                name = observation_name(scene.scene_index, index)
                remove_file(layout.images(split) / f"{name}.png")
                remove_file(layout.labels(split) / f"{name}.txt")
        return EachWriter(partial(self._write, split))

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {name: number for number, name in enumerate(numbered(self._manifest.targets))}

    @cached_property
    def _points(self) -> int:
        return max(points_of(info.pockets) for info in self._objects.values())

    @cached_property
    def _layouts(self) -> dict[Task, YoloLayout]:
        return {task: yolo_layout(self._root, task) for task in TASKS if task != "pose" or self._points}

    def _description(self, task: Task) -> str:
        """Return data.yaml; without ``path``, so that splits lie beside it wherever the folder is."""
        data: dict[str, Any] = {split: f"images/{split}" for split in SPLITS}
        data["names"] = {number: name for name, number in self._numbers.items()}
        if task == "pose":
            data |= {"kpt_shape": [self._points, 3], "flip_idx": mirrored(self._points)}
        return yaml.safe_dump(data, sort_keys=False, default_flow_style=None)

    def _write(self, split: str, files: ObservationFiles) -> None:
        """Write image and labels of one observation for each task.

        Raises:
            DatasetError: A target's class is not among those of the dataset.
        """
        observation = files.observation
        name = observation_name(observation.scene_index, observation.observation_index)
        for task, layout in self._layouts.items():
            files.rgb.save(layout.images(split) / f"{name}.png")
            rows = [self._row(task, files, target) for target in files.targets]
            write_bytes(layout.labels(split) / f"{name}.txt", label_file(rows))

    def _row(self, task: Task, files: ObservationFiles, target: LabelledTarget) -> str:
        annotation, camera = target.annotation, files.observation.camera
        number, size_wh = self._number(annotation.class_name, files), (camera.width, camera.height)
        box = target.box_visible_xyxy
        if task == "detect":
            return box_row(number, box, size_wh)
        if task == "segment":
            return corner_row(number, mask_polygon(target.mask_visible), size_wh)
        if task == "obb":
            return corner_row(number, oriented_box(target.mask_visible), size_wh)
        info, depth = self._objects.get(annotation.obj_id), files.observation.buffers.depth
        pockets = () if info is None else info.pockets
        points = key_points(pockets, annotation.T_camera_object, camera, depth, self._points)
        return point_row(number, box, points, size_wh)

    def _number(self, class_name: str, files: ObservationFiles) -> int:
        if class_name not in self._numbers:
            scene, index = files.observation.scene_index, files.observation.observation_index
            raise DatasetError(
                f"YOLO, scene {scene}, observation {index}: class {class_name} is not among the dataset's targets "
                f"{', '.join(self._numbers)}; add it to the recipe's targets"
            )
        return self._numbers[class_name]
