"""Write BOP shards: each scene into an archive of its own, by any process; the last step streams them into shards."""

import tarfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import ClassVar

from warehouse_sim.dataset.files.extent import Extent
from warehouse_sim.dataset.files.jpeg import QUALITY
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.formats.bop.shards import MOST_IMAGES, ShardsLayout, shards_layout
from warehouse_sim.dataset.formats.bop.shards.archive import Members, add_image, list_members, writing_archive
from warehouse_sim.dataset.formats.bop.shards.coding import LOSSLESS, SMALL, Coding
from warehouse_sim.dataset.formats.bop.writer import TargetLists, require_known, write_preface
from warehouse_sim.dataset.formats.built_in import SceneWriterBase, WriterBase, remove_file, remove_folder
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.layout import observation_name
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.dataset.stored.contents import Contents
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.output import make_folder, whole_file, writing
from warehouse_sim.schema import ObjectModel, SceneSpec

_Key = tuple[int, int]


def merge(layout: ShardsLayout, manifest: Manifest, most_images: int = MOST_IMAGES) -> None:
    """Write all shards, one image in memory at a time, and remove the scenes that are in them.

    Args:
        layout: Paths of the format's folder.
        manifest: Of the dataset.
        most_images: Of one shard.

    Raises:
        DatasetError: A scene is neither in its part nor in its shard.
    """
    targets = TargetLists()
    for split in SPLITS:
        keys = [(scene, i) for scene in manifest.splits[split] for i in range(manifest.observations_per_scene)]
        if not keys:
            continue
        make_folder(layout.split(split))
        table: dict[str, int] = {}
        for number, start in enumerate(range(0, len(keys), most_images)):
            chunk = keys[start : start + most_images]
            members = _write_shard(layout, split, number, chunk)
            table |= {observation_name(*key): number for key in chunk}
            if split == "test":
                _add_targets(targets, members)
            # A scene goes on in the next shard unless its last image is in this one.
            _remove_parts(layout, chunk, manifest.observations_per_scene - 1)
        write_json(layout.key_to_shard(split), table)
    targets.write(layout.bop.root)
    remove_folder(layout.parts)


def _write_shard(layout: ShardsLayout, split: str, number: int, keys: Sequence[_Key]) -> Members:
    """Write a shard of parts, and of the shard itself where it was made before; return its members."""
    path = layout.shard(split, number)
    stored = list_members(path) if path.is_file() else {}
    fresh = {scene for scene, _ in keys if layout.part(scene).is_file()}
    if not fresh and set(stored) == set(keys):
        return stored
    part: Members = {}
    with whole_file(path) as file, writing_archive(file) as archive:
        for key in keys:
            if key[0] in fresh and key not in part:
                part = list_members(layout.part(key[0]))
            found: dict[str, Extent] | None = part.get(key) if key[0] in fresh else stored.get(key)
            if found is None:
                raise DatasetError(
                    f"{path}: image {observation_name(*key)} is neither in {layout.part(key[0])} nor in the shard; "
                    "generate the dataset again"
                )
            add_image(archive, observation_name(*key), {kind: extent.read() for kind, extent in found.items()})
    return list_members(path)


def _add_targets(targets: TargetLists, members: Members) -> None:
    for (scene, image), kinds in members.items():
        rows = [read_json(kinds[kind]) for kind in ("gt.json", "gt_info.json")]
        targets.add(scene, image, *rows)


def _remove_parts(layout: ShardsLayout, keys: Sequence[_Key], last: int) -> None:
    for scene, image in keys:
        if image == last:
            remove_file(layout.part(scene))


_INFO = f"""\
- Images are in shards (BOP webdataset): plain tar archives of {MOST_IMAGES} images at most, in order of scene and
  image; shuffle them when you stream. key_to_shard.json says where each is. A member is SCENE_IMAGE.kind: camera.json,
  gt.json and gt_info.json are the rows that scene_camera.json, scene_gt.json and scene_gt_info.json have scenewise,
  mask.json and mask_visib.json run lengths by the index in gt.json. Of an image without targets they are empty.
"""


_COMPACT_INFO = f"""\
- Colours are JPEG of quality {QUALITY} with halved colour differences; depth is exact. Run lengths are COCO's strings.
"""


class ShardsWriter(WriterBase):
    """Write scenes as ``bop_webdataset/{train,val,test}/shard-%06d.tar``."""

    coding: ClassVar[Coding] = LOSSLESS

    def __init__(self, root: Path, manifest: Manifest) -> None:
        super().__init__(root, manifest)
        self._layout = shards_layout(root, self.coding.name)

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Write the meshes, the sensor defaults and the description."""
        text = _INFO + (_COMPACT_INFO if self.coding.compact else "")
        write_preface(self._layout.root, self._manifest, models, camera, text)
        make_folder(self._layout.parts)

    def scene(self, scene: SceneSpec) -> "ShardsSceneWriter":
        """Open a scene again."""
        path = self._layout.part(scene.scene_index)
        make_folder(path.parent)
        return ShardsSceneWriter(path, self._objects, self._manifest.contents, self.coding)

    def finish(self) -> None:
        """Stream the scenes into shards; write the tables of keys and the targets of the test split."""
        merge(self._layout, self._manifest)


class CompactWriter(ShardsWriter):
    """Write scenes as ``bop_compact/{train,val,test}/shard-%06d.tar``."""

    coding: ClassVar[Coding] = SMALL


class ShardsSceneWriter(SceneWriterBase):
    """Write the images of one scene into an archive of their own, each as it comes."""

    def __init__(self, path: Path, objects: Mapping[int, ObjectInfo], contents: Contents, coding: Coding) -> None:
        self._path, self._objects, self._contents, self._coding = path, objects, contents, coding
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
        observation = files.observation
        where = f"BOP, scene {observation.scene_index}, observation {observation.observation_index}"
        for target in files.targets:
            require_known(target.annotation.obj_id, self._objects, where)
        members = self._coding.members(files, self._contents)
        with writing(self._path):
            add_image(self._archive, observation_name(observation.scene_index, observation.observation_index), members)

    def finish(self) -> None:
        """Close the archive."""
        with writing(self._path):
            self._open.close()
