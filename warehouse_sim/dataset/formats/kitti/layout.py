"""Where everything lies in a KITTI folder, and which frame an observation is."""

from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.stored.contents import Contents

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
