"""The BOP format, scenewise: https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md."""

import shutil
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.files.json_file import read_table, write_json
from warehouse_sim.dataset.formats.bop.labels import (
    camera_row,
    coco_annotation,
    coco_image,
    pose_row,
    visibility_row,
)
from warehouse_sim.dataset.formats.bop.layout import BopSceneLayout, bop_layout
from warehouse_sim.dataset.formats.bop.preface import write_preface
from warehouse_sim.dataset.formats.bop.targets import TargetLists
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.output import make_folder, writing
from warehouse_sim.schema import ObjectModel, SceneSpec


class BopWriter:
    """Write scenes as ``bop/{train,val,test}/%06d``."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        self._root, self._manifest = root, manifest
        self._layout = bop_layout(root)
        self._clean = manifest.contents.clean

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Write the meshes, the sensor defaults and the description."""
        write_preface(self._layout.root, self._manifest, models, camera)

    def scene(self, scene: SceneSpec) -> "BopSceneWriter":
        """Open a scene again."""
        layout = self._layout.scene(self._manifest.split_of(scene.scene_index), scene.scene_index)
        if layout.root.exists():
            with writing(layout.root):
                shutil.rmtree(layout.root)
        return BopSceneWriter(layout, self._objects, self._clean)

    def finish(self) -> None:
        """Write the targets of the test split."""
        targets = TargetLists()
        for scene_id in self._manifest.splits["test"]:
            scene = self._layout.scene("test", scene_id)
            poses, infos = read_table(scene.table("gt")), read_table(scene.table("gt_info"))
            for image_id, row in poses.items():
                targets.add(scene_id, image_id, row, infos[image_id])
        targets.write(self._layout.root)

    @cached_property
    def _objects(self) -> dict[int, ObjectInfo]:
        return read_objects(self._root)


class BopSceneWriter:
    """Write one scene: its images as they come, then its tables."""

    def __init__(self, layout: BopSceneLayout, objects: dict[int, ObjectInfo], clean: bool) -> None:
        self._layout, self._objects, self._clean = layout, objects, clean
        for name in ("rgb", "depth", "mask", "mask_visib", *(("rgb_clean", "depth_clean") if clean else ())):
            make_folder(layout.root / name)
        self._cameras: dict[int, dict[str, Any]] = {}
        self._poses: dict[int, list[dict[str, Any]]] = {}
        self._infos: dict[int, list[dict[str, Any]]] = {}
        self._images: list[dict[str, Any]] = []
        self._annotations: list[dict[str, Any]] = []

    def write(self, files: ObservationFiles) -> None:
        """Write the images of one observation and keep its labels.

        Raises:
            DatasetError: A label names a geometry that the dataset does not have, or a depth does not fit.
        """
        observation = files.observation
        image_id = observation.observation_index
        where = f"BOP, scene {observation.scene_index}, observation {image_id}"
        files.rgb.save(self._layout.rgb(image_id))
        files.depth_mm.save(self._layout.depth(image_id))
        if self._clean:
            files.rgb_clean.save(self._layout.rgb_clean(image_id))
            files.depth_clean_mm.save(self._layout.depth_clean(image_id))
        for gt_index, target in enumerate(files.targets):
            require_known(target.annotation.obj_id, self._objects, where)
            target.mask_png.save(self._layout.mask(image_id, gt_index, visible=False))
            target.mask_visible_png.save(self._layout.mask(image_id, gt_index, visible=True))
            self._annotations.append(coco_annotation(len(self._annotations) + 1, image_id, target))
        self._cameras[image_id] = camera_row(observation)
        self._poses[image_id] = [pose_row(target.annotation) for target in files.targets]
        self._infos[image_id] = [visibility_row(target, observation.rgbd.depth) for target in files.targets]
        self._images.append(coco_image(image_id, observation.camera))

    def finish(self) -> None:
        """Write the scene's tables."""
        categories = [
            {"id": info.obj_id, "name": info.name, "supercategory": info.class_name} for info in self._objects.values()
        ]
        coco = {
            "info": {"description": "visible masks and amodal boxes of the targets of one scene"},
            "licenses": [],
            "categories": categories,
            "images": self._images,
            "annotations": self._annotations,
        }
        write_json(self._layout.table("camera"), self._cameras)
        write_json(self._layout.table("gt"), self._poses)
        write_json(self._layout.table("gt_info"), self._infos)
        write_json(self._layout.table("gt_coco"), coco, depth=2)


def require_known(obj_id: int, objects: Mapping[int, ObjectInfo], where: str) -> None:
    """Reject a label of a geometry that the dataset does not have.

    Raises:
        DatasetError: It has not.
    """
    if obj_id not in objects:
        raise DatasetError(
            f"{where}: obj_id {obj_id} is not among the dataset's objects {sorted(objects)}; "
            "hand every target's model to DatasetStore.begin"
        )
