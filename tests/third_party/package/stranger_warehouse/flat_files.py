"""A dataset format: one .npz file an observation, with its labels in it, and the scene's objects beside it."""

import io
import json
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.checks.findings import Findings, NamedCheck
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.manifest import Manifest, read_manifest
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import ObjectModel, SceneSpec

NAME = "flat_files"
_TARGET_FIELDS = (
    "instance_id", "obj_id", "T_camera_object", "visible_fraction", "pixels_visible", "box_visible_xyxy",
    "box_amodal_xyxy", "pixels_valid", "pixels_all",
)  # fmt: skip


def folder_of(root: Path, manifest: Manifest, scene_index: int) -> Path:
    """Return the folder of a scene."""
    return root / NAME / manifest.split_of(scene_index) / f"{scene_index:06d}"


class FlatSceneWriter:
    """Writes one scene: ``scene.json`` first, as it needs no observation."""

    def __init__(self, folder: Path, scene: SceneSpec) -> None:
        self._folder = folder
        make_folder(folder)
        objects = {str(item.instance_id): item.model for item in scene.instances}
        write_bytes(folder / "scene.json", json.dumps({"objects": objects}, indent=1).encode("utf-8"))

    def write(self, files: ObservationFiles) -> None:
        """Store one observation."""
        seen, camera = files.observation, files.observation.camera
        arrays: dict[str, Any] = {
            "rgb": seen.rgbd.rgb,
            "depth": seen.rgbd.depth,
            "K": camera.K,
            "T_world_camera": seen.T_world_camera,
            "masks": np.array([item.mask for item in files.targets], bool).reshape(-1, *seen.rgbd.depth.shape),
            "masks_visible": np.array([item.mask_visible for item in files.targets], bool).reshape(
                -1, *seen.rgbd.depth.shape
            ),
        }
        for name in _TARGET_FIELDS:
            arrays[name] = np.array([getattr(item.annotation, name) for item in files.targets])
        _write_npz(self._folder / f"{seen.observation_index:06d}.npz", arrays)

    def finish(self) -> None:
        """Nothing covers the whole scene but what is written."""


class FlatWriter:
    """Writes the folder of the format."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        self._root, self._manifest = root, manifest

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Store the surfaces."""
        make_folder(self._root / NAME / "models")
        for model in models:
            mesh = model.mesh()
            arrays = {"vertices": mesh.vertices, "faces": mesh.faces}
            _write_npz(self._root / NAME / "models" / f"{model.obj_id}.npz", arrays)

    def scene(self, scene: SceneSpec) -> FlatSceneWriter:
        """Open a scene."""
        return FlatSceneWriter(folder_of(self._root, self._manifest, scene.scene_index), scene)

    def finish(self) -> None:
        """Nothing needs all scenes."""


class FlatReader:
    """Reads what the writer wrote."""

    has_clean = False

    def __init__(self, root: Path) -> None:
        self._root, self._manifest = root, read_manifest(root)

    @cached_property
    def objects(self) -> Mapping[int, ObjectInfo]:
        """The CAD geometries."""
        return read_objects(self._root, self._mesh)

    @property
    def splits(self) -> Mapping[str, tuple[int, ...]]:
        """Those of the manifest."""
        return self._manifest.splits

    def images(self, split: str) -> list[ImageRecord]:
        """Return the images of a split.

        Raises:
            DatasetError: There is no such split.
        """
        if split not in self.splits:
            raise DatasetError(f"{self._root}: there is no split {split!r}; known: {', '.join(self.splits)}")
        return [
            self._image(split, scene, number)
            for scene in self.splits[split]
            for number in range(self._manifest.observations_per_scene)
        ]

    def files(self, split: str) -> list[Path]:
        """Return the files of a split."""
        return sorted(path for scene in self.splits[split] for path in self._folder(scene).iterdir())

    def rgb(self, image: ImageRecord) -> np.ndarray:
        """Read the colours."""
        return self._arrays(image)["rgb"]

    def depth(self, image: ImageRecord) -> np.ndarray:
        """Read the depth (m)."""
        return self._arrays(image)["depth"]

    def clean_rgb(self, image: ImageRecord) -> np.ndarray:
        """There are none.

        Raises:
            DatasetError: Always.
        """
        raise DatasetError(f"{self._root}: {NAME} holds no clean images")

    clean_depth = clean_rgb

    def mask_visible(self, image: ImageRecord, gt_index: int) -> np.ndarray:
        """Read one mask."""
        return self._arrays(image)["masks_visible"][gt_index]

    def mask(self, image: ImageRecord, gt_index: int) -> np.ndarray:
        """Read one amodal mask."""
        return self._arrays(image)["masks"][gt_index]

    def _folder(self, scene: int) -> Path:
        return folder_of(self._root, self._manifest, scene)

    def _arrays(self, image: ImageRecord) -> Mapping[str, np.ndarray]:
        return _read_npz(self._folder(image.scene_id) / f"{image.image_id:06d}.npz")

    def _image(self, split: str, scene: int, number: int) -> ImageRecord:
        data = _read_npz(self._folder(scene) / f"{number:06d}.npz")
        height, width = data["depth"].shape
        K = data["K"]
        camera = PinholeCamera(width, height, *(float(value) for value in (K[0, 0], K[1, 1], K[0, 2], K[1, 2])))
        targets = []
        for index in range(len(data["obj_id"])):
            values = {name: data[name][index] for name in _TARGET_FIELDS}
            values = {name: value if value.ndim else value.item() for name, value in values.items()}
            values |= {name: tuple(values[name].tolist()) for name in ("box_visible_xyxy", "box_amodal_xyxy")}
            targets.append(TargetRecord(gt_index=index, **values))
        return ImageRecord(split, scene, number, camera, data["T_world_camera"], 1.0, tuple(targets))

    def _mesh(self, obj_id: int, even: bool) -> TriangleMesh:
        data = _read_npz(self._root / NAME / "models" / f"{obj_id}.npz")
        return TriangleMesh(data["vertices"], data["faces"])


def every_mask_has_its_object(subject: Any) -> Findings:
    """Check that each label's object is one of its scene, and that its mask shows as many pixels as it says."""
    findings, seen = Findings(), 0
    for scene in range(subject.manifest.scenes):
        folder = folder_of(subject.root, subject.manifest, scene)
        objects = json.loads((folder / "scene.json").read_text(encoding="utf-8"))["objects"]
        for path in sorted(folder.glob("*.npz")):
            data = _read_npz(path)
            for index, instance in enumerate(data["instance_id"].tolist()):
                seen += 1
                findings.require(str(instance) in objects, f"{path}: object {instance} is not in scene.json")
                shown, told = int(data["masks_visible"][index].sum()), int(data["pixels_visible"][index])
                findings.require(shown == told, f"{path}: the mask of object {instance} has {shown} px, not {told}")
    findings.examined = f"{seen} labels"
    return findings


class FlatFormat:
    """The format; depth is stored as it is, so that nothing is rejected."""

    name = NAME
    checks = (NamedCheck("flat files", every_mask_has_its_object),)

    def reject(self, manifest: Manifest) -> None:
        """Reject nothing."""

    def writer(self, root: Path, manifest: Manifest) -> FlatWriter:
        """Return a writer."""
        return FlatWriter(root, manifest)

    def reader(self, root: Path) -> FlatReader:
        """Return a reader."""
        return FlatReader(root)

    def recognises(self, root: Path) -> bool:
        """A folder of it always has a manifest."""
        return False


FORMAT = FlatFormat()


def _write_npz(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    write_bytes(path, buffer.getvalue())


def _read_npz(path: Path) -> Mapping[str, np.ndarray]:
    if not path.is_file():
        raise DatasetError(f"{path}: is missing; generate the dataset again")
    with np.load(path, allow_pickle=False) as data:
        return {name: data[name] for name in data.files}
