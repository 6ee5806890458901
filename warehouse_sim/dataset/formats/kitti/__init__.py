"""The KITTI object detection format, strict enough for OpenPCDet, mmdet3d, Open3D-ML, torchvision and the devkit."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.stored.contents import Contents
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.level_view import STEEPEST
from warehouse_sim.schema import LidarScan, MountedReading, Observation

STEPS_PER_METRE = 256.0
"""Of the depth images."""
_LARGEST_FRAME = 999_999
_LARGEST_CAMERA_TILT = math.radians(0.1)


def misfits(manifest: Manifest) -> Iterator[str]:
    """Yield what of a dataset the format cannot hold, before any of it is made."""
    contents = manifest.contents
    if manifest.scenes * manifest.observations_per_scene > _LARGEST_FRAME + 1:
        yield (
            f"{manifest.scenes} scenes of {manifest.observations_per_scene} observations need more than six "
            "digits; make several datasets with fewer --scenes"
        )
    for name in manifest.targets:
        if len(name.split()) != 1 or name != name.strip() or not name.isascii() or name == "DontCare":
            yield (
                f"targets: the class name {name!r} must be one ASCII word other than DontCare in a KITTI label; "
                "rename the class"
            )
    if contents.view_angle_deg > math.degrees(STEEPEST):
        yield (
            f"viewpoints.kind {', '.join(contents.tilted_viewpoints)} shows what lies "
            f"{contents.view_angle_deg:.0f} deg from the horizon, but the level camera that KITTI is written through "
            f"sees {math.degrees(STEEPEST):.0f} deg; narrow viewpoints.pitch_deg (of free: elevation_deg) or the camera"
        )
    if contents.lidar is None:
        yield "sensors.lidar is null, but every KITTI frame has a sweep; give the recipe a LiDAR"


def require_level(observation: Observation, where: str) -> None:
    """Reject what a KITTI label cannot say: its only angle is about the camera's y axis, which must be vertical.

    Raises:
        DatasetError: The camera is tilted.
    """
    world_up = np.array([0.0, 0.0, 1.0])
    camera_up = -observation.T_world_camera[:3, 1]
    tilt = _angle(camera_up, world_up)
    if tilt > _LARGEST_CAMERA_TILT:
        raise DatasetError(
            f"{where}: the camera is tilted by {math.degrees(tilt):.2f} deg, KITTI needs a level camera; "
            "hand the writer its level view, set viewpoints.level: true, or leave kitti out of --formats"
        )


def _angle(a: np.ndarray, b: np.ndarray) -> float:
    # Half the chord between unit vectors: arccos would lose small angles.
    return 2.0 * math.asin(min(float(np.linalg.norm(a - b)) / 2.0, 1.0))


NAME = "kitti"
"""Of the format and of its folder in a dataset."""


@dataclass(frozen=True)
class KittiLayout:
    """Paths of a KITTI object detection dataset; train and validation frames share the folder ``training``."""

    root: Path

    def image_set(self, name: str) -> Path:
        """Return the list of the frames of a split, or of "trainval"."""
        return self.root / "ImageSets" / f"{name}.txt"

    def folder(self, split: str) -> Path:
        """Return the folder of the frames of a split."""
        return self.root / ("testing" if split == "test" else "training")

    def file(self, split: str, kind: str, frame: int) -> Path:
        """Return one file of a frame; ``kind`` is one of those of ``kitti_kinds``."""
        return self.folder(split) / kind / f"{frame:06d}.{_ending(kind)}"


KITTI_KINDS = {
    "image_2": "png",
    "depth_2": "png",
    "velodyne": "bin",
    "velodyne_ids": "bin",
    "velodyne_beams": "bin",
    "calib": "txt",
    "label_2": "txt",
    "label_2_ids": "txt",
    "planes": "txt",
}
"""Folders of a KITTI frame's files and how the files end; those called ids and beams are this package's own."""
_STEREO_KINDS = {"image_3": "png", "disp_occ": "png", "disp_noc": "png"}
_MATCHED_KINDS = {"disp_sgbm": "png"}
_CLEAN_KINDS = {"image_clean_2": "png", "depth_clean_2": "png"}
_CLEAN_STEREO_KINDS = {"image_clean_3": "png"}


def kitti_kinds(contents: Contents) -> dict[str, str]:
    """Return the folders of a frame's files and how the files end, for the sensors of a dataset."""
    kinds, is_stereo = dict(KITTI_KINDS), contents.baseline is not None
    if is_stereo:
        kinds |= _STEREO_KINDS | (_MATCHED_KINDS if contents.matched else {})
    if contents.clean:
        kinds |= _CLEAN_KINDS | (_CLEAN_STEREO_KINDS if is_stereo else {})
    for name in contents.lidars:
        kinds |= {f"velodyne_{name}": "bin", f"velodyne_{name}_ids": "bin"}
    return kinds | ({"calib_lidars": "txt"} if contents.lidars else {})


def frames_of(manifest: Manifest, scene_index: int) -> range:
    """Return the frame numbers of a scene's observations."""
    per_scene = manifest.observations_per_scene
    return range(scene_index * per_scene, (scene_index + 1) * per_scene)


def _ending(kind: str) -> str:
    known = KITTI_KINDS | _STEREO_KINDS | _MATCHED_KINDS | _CLEAN_KINDS | _CLEAN_STEREO_KINDS | {"calib_lidars": "txt"}
    return "bin" if kind.startswith("velodyne_") else known[kind]


def kitti_layout(root: Path) -> KittiLayout:
    """Return the paths of the KITTI files of a dataset."""
    return KittiLayout(DatasetLayout(root).format_folder(NAME))


class KittiFormat(BuiltIn):
    """One file a frame of every kind: image, sweep, calibration, upright 3D boxes."""

    needs_level_camera = True

    def reject(self, manifest: Manifest) -> None:
        """Reject views far below the horizon, a rig without LiDAR, long class names, too many frames, far depth."""
        for problem in misfits(manifest):
            raise DatasetError(f"KITTI: {problem}, or leave kitti out of --formats")
        super().reject(manifest)

    def reader(self, root: Path) -> FormatReader | None:
        """Return a reader of a folder without a manifest; None of one with it: what leans has no box, nothing a mask.

        To read the KITTI files of such a dataset as third-party ones are read, give the folder ``kitti`` in it.
        """
        if DatasetLayout(root).manifest.is_file():
            return None
        from warehouse_sim.dataset.formats.kitti.external import ExternalKittiReader, external_folder

        folder = external_folder(root)
        return None if folder is None else ExternalKittiReader(folder)

    def sweep(self, root: Path, manifest: Manifest, image: ImageRecord) -> MountedReading[LidarScan]:
        """Read the main LiDAR's sweep of an image of a dataset with a manifest."""
        from warehouse_sim.dataset.formats.kitti.external_frame import stored_sweep

        return stored_sweep(root, manifest, image)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder, or ``kitti`` in it, holds frames of KITTI."""
        from warehouse_sim.dataset.formats.kitti.external import external_folder

        return external_folder(root) is not None


FORMAT = KittiFormat(
    NAME,
    checks_at="warehouse_sim.dataset.formats.kitti.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.kitti.writer:KittiWriter",
    needs=("rgb", "depth", "poses", "lidar"),
    holds=("rgb", "depth", "poses", "lidar", "right", "clean"),
    counts=("masks", "amodal_masks"),
    steps_per_metre=STEPS_PER_METRE,
)
