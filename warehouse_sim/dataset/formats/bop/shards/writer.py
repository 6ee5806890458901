"""Write BOP shards: each scene into an archive of its own, by any process; the last step streams them into shards."""

import json
import tarfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from functools import cached_property
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.formats.bop.labels import camera_row, pose_row, visibility_row
from warehouse_sim.dataset.formats.bop.preface import write_preface
from warehouse_sim.dataset.formats.bop.shards.archive import add_image, writing_archive
from warehouse_sim.dataset.formats.bop.shards.layout import MOST_IMAGES, image_key, shards_layout
from warehouse_sim.dataset.formats.bop.shards.merge import merge
from warehouse_sim.dataset.formats.bop.writer import require_known
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.output import make_folder, writing
from warehouse_sim.schema import ObjectModel, SceneSpec

_INFO = f"""\
- Images are in shards (BOP webdataset): plain tar archives of {MOST_IMAGES} images at most, in order of scene and
  image; shuffle them when you stream. key_to_shard.json says where each is. A member is SCENE_IMAGE.kind: camera.json,
  gt.json and gt_info.json are the rows that scene_camera.json, scene_gt.json and scene_gt_info.json have scenewise,
  mask.json and mask_visib.json run lengths by the index in gt.json. Of an image without targets they are empty.
"""


class ShardsWriter:
    """Write scenes as ``bop_webdataset/{train,val,test}/shard-%06d.tar``."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        self._root, self._manifest = root, manifest
        self._layout = shards_layout(root)

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Write the meshes, the sensor defaults and the description."""
        write_preface(self._layout.root, self._manifest, models, camera, _INFO)
        make_folder(self._layout.parts)

    def scene(self, scene: SceneSpec) -> "ShardsSceneWriter":
        """Open a scene again."""
        path = self._layout.part(scene.scene_index)
        make_folder(path.parent)
        return ShardsSceneWriter(path, self._objects, self._manifest.contents.clean)

    def finish(self) -> None:
        """Stream the scenes into shards; write the tables of keys and the targets of the test split."""
        merge(self._layout, self._manifest)

    @cached_property
    def _objects(self) -> dict[int, ObjectInfo]:
        return read_objects(self._root)


class ShardsSceneWriter:
    """Write the images of one scene into an archive of their own, each as it comes."""

    def __init__(self, path: Path, objects: Mapping[int, ObjectInfo], clean: bool) -> None:
        self._path, self._objects, self._clean = path, objects, clean
        self._open = ExitStack()
        with writing(path):
            # What an interrupted run left of it is overwritten; until the scene is complete, nobody reads it.
            self._archive: tarfile.TarFile = self._open.enter_context(
                writing_archive(self._open.enter_context(path.open("wb")))
            )

    def write(self, files: ObservationFiles) -> None:
        """Append one observation.

        Raises:
            DatasetError: A label names a geometry that the dataset does not have, or a depth does not fit.
        """
        observation, targets = files.observation, files.targets
        where = f"BOP, scene {observation.scene_index}, observation {observation.observation_index}"
        for target in targets:
            require_known(target.annotation.obj_id, self._objects, where)
        members = {
            "rgb.png": files.rgb.data,
            "depth.png": files.depth_mm.data,
            "camera.json": _json(camera_row(observation)),
            "gt.json": _json([pose_row(target.annotation) for target in targets]),
            "gt_info.json": _json([visibility_row(target, observation.rgbd.depth) for target in targets]),
            "mask.json": _json({str(i): target.runs for i, target in enumerate(targets)}),
            "mask_visib.json": _json({str(i): target.runs_visible for i, target in enumerate(targets)}),
        }
        if self._clean:
            members |= {"rgb_clean.png": files.rgb_clean.data, "depth_clean.png": files.depth_clean_mm.data}
        with writing(self._path):
            add_image(self._archive, image_key(observation.scene_index, observation.observation_index), members)

    def finish(self) -> None:
        """Close the archive."""
        with writing(self._path):
            self._open.close()


def _json(data: Any) -> bytes:
    return json.dumps(data, allow_nan=False).encode("ascii")
