"""Write DenseFusion's LINEMOD layout: a folder of each object, a frame for each time that it is seen.

LINEMOD labels one object in an image. Of an image that shows several, or one several times, each makes a frame of its
own with the mask of that one; the images are hard links. Frames are numbered when all scenes are there: how many come
before depends on all of them.
"""

import io
import os
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.files.image_io import encode_rgb
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.files.plain import WHOLE, take
from warehouse_sim.dataset.formats.bop.models import even_mesh, model_info
from warehouse_sim.dataset.formats.bop.tables import pose_row, visibility_row
from warehouse_sim.dataset.formats.bop.writer import require_known
from warehouse_sim.dataset.formats.built_in import SceneWriterBase, WriterBase, remove_folder
from warehouse_sim.dataset.formats.linemod import KINDS, NO_LENS, LinemodLayout, linemod_layout, yaml_row
from warehouse_sim.dataset.formats.observation_files import LabelledTarget, ObservationFiles, SharedFile
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.output import make_folder, write_bytes, writing
from warehouse_sim.schema import ObjectModel, SceneSpec

# DenseFusion reads the fourth line as the number of vertices, whatever stands above it.
_HEADER = """ply
format ascii 1.0
comment millimetres, z up, origin at the centre of the bounding box
element vertex {vertices}
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
"""


def write_linemod_models(layout: LinemodLayout, models: Sequence[ObjectModel]) -> None:
    """Write the meshes, whose evenly spread vertices are the points that errors use, and their table."""
    make_folder(layout.models_info.parent)
    lines = []
    for model in sorted(models, key=lambda model: model.obj_id):
        mesh = even_mesh(model)
        mesh_mm = TriangleMesh(mesh.vertices * 1000.0, mesh.faces)
        _write_text_ply(layout.model(model.obj_id), mesh_mm)
        lines.append(f"{model.obj_id}: {yaml_row(model_info(model, mesh_mm))}\n")
    write_bytes(layout.models_info, "".join(lines).encode("ascii"), durable=True)


def _write_text_ply(path: Path, mesh: TriangleMesh) -> None:
    text = io.StringIO()
    text.write(_HEADER.format(vertices=len(mesh.vertices), faces=len(mesh.faces)))
    np.savetxt(text, mesh.vertices.astype(np.float32), "%.9g")
    np.savetxt(text, np.insert(mesh.faces, 0, 3, axis=1), "%d")
    write_bytes(path, text.getvalue().encode("ascii"), durable=True)


class LinemodWriter(WriterBase):
    """Write ``linemod/data/%02d``."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        super().__init__(root, manifest)
        self._layout = linemod_layout(root)

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Write the meshes.

        Raises:
            DatasetError: The camera has a lens, for which the layout has no place.
        """
        _require_pinhole(camera)
        write_linemod_models(self._layout, models)

    def scene(self, scene: SceneSpec) -> "LinemodSceneWriter":
        """Open a scene again."""
        remove_folder(self._layout.part(scene.scene_index))
        is_test = self._manifest.split_of(scene.scene_index) == "test"
        return LinemodSceneWriter(self._layout, scene.scene_index, self._objects, is_test)

    def finish(self) -> None:
        """Give every frame its number; write the tables and the lists of each split."""
        frames: dict[int, int] = defaultdict(int)
        lists: dict[int, dict[str, list[int]]] = defaultdict(lambda: {split: [] for split in SPLITS})
        for scene in self._manifest.scene_indices:
            texts: dict[Path, str] = defaultdict(str)
            for row in read_json(self._layout.scene(scene)):
                obj_id = take(row, "obj_id", int, str(self._layout.scene(scene)), WHOLE)
                frame, folder = frames[obj_id], self._layout.object_folder(obj_id)
                self._place(scene, row, frame)
                texts[folder / "gt.yml"] += f"{frame}:\n- {yaml_row(row['gt'])}\n"
                texts[folder / "info.yml"] += f"{frame}: {yaml_row(row['info'])}\n"
                lists[obj_id][self._manifest.split_of(scene)].append(frame)
                frames[obj_id] += 1
            for path, text in texts.items():
                _append(path, text, overwrite=text.startswith("0:"))
        for obj_id, by_split in lists.items():
            for split, numbers in by_split.items():
                text = "".join(f"{number:04d}\n" for number in numbers)
                path = self._layout.object_folder(obj_id) / f"{split}.txt"
                write_bytes(path, text.encode("ascii"), durable=True)
        remove_folder(self._layout.parts)

    def _place(self, scene: int, row: Mapping[str, Any], frame: int) -> None:
        """Move the images of a frame to their place, unless an interrupted run did."""
        obj_id, part = row["obj_id"], self._layout.part(scene)
        places = {kind: self._layout.image(obj_id, kind, frame) for kind in KINDS}
        if self._manifest.split_of(scene) == "test":
            places["label"] = self._layout.label(obj_id, frame)
        for kind, path in places.items():
            source = part / _part_name(row, kind)
            if source.is_file():
                make_folder(path.parent)
                with writing(path):
                    os.replace(source, path)
            elif not path.is_file():
                raise DatasetError(f"{path}: is missing, and so is {source}; generate the dataset again")


class LinemodSceneWriter(SceneWriterBase):
    """Write one scene: the images of its frames, then what its frames are."""

    def __init__(
        self, layout: LinemodLayout, scene_index: int, objects: Mapping[int, ObjectInfo], is_test: bool
    ) -> None:
        self._layout, self._scene, self._objects, self._is_test = layout, scene_index, objects, is_test
        self._rows: list[dict[str, Any]] = []
        make_folder(layout.part(scene_index))

    def write(self, files: ObservationFiles) -> None:
        """Store a frame for each labelled target.

        Raises:
            DatasetError: A label names a geometry that the dataset does not have, a depth does not fit, or the camera
                has a lens.
        """
        observation = files.observation
        where = f"LINEMOD, scene {observation.scene_index}, observation {observation.observation_index}"
        _require_pinhole(observation.camera)
        for gt_index, target in enumerate(files.targets):
            require_known(target.annotation.obj_id, self._objects, where)
            row = {
                "obj_id": target.annotation.obj_id,
                "observation": observation.observation_index,
                "gt_index": gt_index,
                "gt": _label(files, target),
                "info": {"cam_K": observation.camera.K.ravel().tolist(), "depth_scale": 1.0},
            }
            white = np.repeat(target.mask_visible[..., None], 3, axis=2).view(np.uint8) * np.uint8(255)
            contents = {"rgb": files.rgb, "depth": files.depth_mm, "mask": SharedFile(encode_rgb(white))}
            if self._is_test:
                contents["label"] = target.mask_visible_png
            for kind, content in contents.items():
                content.save(self._layout.part(self._scene) / _part_name(row, kind))
            self._rows.append(row)

    def finish(self) -> None:
        """Write which frames the scene gives."""
        make_folder(self._layout.scene(self._scene).parent)
        write_json(self._layout.scene(self._scene), self._rows)


def _label(files: ObservationFiles, target: LabelledTarget) -> dict[str, Any]:
    """Return an entry of gt.yml; beside LINEMOD's four keys those of BOP's scene_gt_info.json, which no one minds."""
    info = visibility_row(target, files.observation.rgbd.depth)
    # DenseFusion slices images with it: whole numbers.
    box = [round(value) for value in info["bbox_obj"]]
    return {**pose_row(target.annotation), "obj_bb": box, **info}


def _part_name(row: Mapping[str, Any], kind: str) -> str:
    return f"{row['observation']:06d}_{row['gt_index']:06d}_{kind}.png"


def _append(path: Path, text: str, overwrite: bool) -> None:
    with writing(path), open(path, "wb" if overwrite else "ab") as file:
        file.write(text.encode("ascii"))


def _require_pinhole(camera: PinholeCamera) -> None:
    if camera.distortion is not None:
        raise DatasetError(NO_LENS)
