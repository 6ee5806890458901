"""Where everything lies in a dataset folder; the one place that knows file names."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.recorded_rig import recorded_rig
from warehouse_sim.dataset.split import Split


@dataclass(frozen=True)
class DatasetLayout:
    """Paths of what every dataset has, whatever its formats."""

    root: Path

    @property
    def manifest(self) -> Path:
        """The file that is written last: its presence says that the dataset is complete."""
        return self.root / "manifest.json"

    @property
    def unfinished(self) -> Path:
        """The manifest of a dataset that is still being made."""
        return self.root / "manifest.unfinished.json"

    @property
    def objects(self) -> Path:
        """What is known of each CAD geometry."""
        return self.root / "objects.json"

    @property
    def scenes(self) -> Path:
        """Folder of the scene records."""
        return self.root / "scenes"

    def scene_record(self, scene_index: int) -> Path:
        """Return the record of a scene, written last of all its files."""
        return self.scenes / f"{scene_index:06d}.json"

    def format_folder(self, name: str) -> Path:
        """Return the folder of a dataset format."""
        return self.root / name


@dataclass(frozen=True)
class BopLayout:
    """Paths of a BOP dataset in the scenewise layout."""

    root: Path

    @property
    def camera(self) -> Path:
        """Sensor defaults."""
        return self.root / "camera.json"

    def models_info(self, kind: str) -> Path:
        """Return the table of sizes, diameters and symmetries of ``kind``, "models" or "models_eval"."""
        return self.root / kind / "models_info.json"

    def model(self, kind: str, obj_id: int) -> Path:
        """Return the file of a mesh in millimetres."""
        return self.root / kind / f"obj_{obj_id:06d}.ply"

    def targets(self, year: int) -> Path:
        """Return the list of what to estimate on the test split, in the form of the challenge of 2019 or 2024."""
        return self.root / f"test_targets_bop{year % 100:02d}.json"

    def scene(self, split: Split, scene_id: int) -> "BopSceneLayout":
        """Return the paths of one scene."""
        return BopSceneLayout(self.root / split / f"{scene_id:06d}")


@dataclass(frozen=True)
class BopSceneLayout:
    """Paths of one BOP scene; image ids are observation indices."""

    root: Path

    def table(self, name: str) -> Path:
        """Return one of the scene's JSON tables: camera, gt, gt_info or gt_coco."""
        return self.root / f"scene_{name}.json"

    def rgb(self, image_id: int) -> Path:
        """Return the file of a colour image."""
        return self.root / "rgb" / f"{image_id:06d}.png"

    def depth(self, image_id: int) -> Path:
        """Return the file of a depth image."""
        return self.root / "depth" / f"{image_id:06d}.png"

    def rgb_clean(self, image_id: int) -> Path:
        """Return the file of a colour image as it was drawn."""
        return self.root / "rgb_clean" / f"{image_id:06d}.png"

    def depth_clean(self, image_id: int) -> Path:
        """Return the file of a depth image without errors of a sensor."""
        return self.root / "depth_clean" / f"{image_id:06d}.png"

    def mask(self, image_id: int, gt_index: int, visible: bool) -> Path:
        """Return the mask of a target: its visible part or the part of its whole silhouette that lies in the image."""
        return self.root / ("mask_visib" if visible else "mask") / f"{image_id:06d}_{gt_index:06d}.png"


@dataclass(frozen=True)
class KittiLayout:
    """Paths of a KITTI object detection dataset; train and validation frames share the folder ``training``."""

    root: Path

    def image_set(self, name: str) -> Path:
        """Return the list of the frames of a split, or of "trainval"."""
        return self.root / "ImageSets" / f"{name}.txt"

    def folder(self, split: Split) -> Path:
        """Return the folder of the frames of a split."""
        return self.root / ("testing" if split == "test" else "training")

    def file(self, split: Split, kind: str, frame: int) -> Path:
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


def stores_clean(recipe: dict[str, Any]) -> bool:
    """Return whether a dataset of this resolved recipe holds clean depth and colour beside the readings."""
    return recorded_rig(recipe).clean


def kitti_kinds(recipe: dict[str, Any]) -> dict[str, str]:
    """Return the folders of a frame's files and how the files end, for the sensors of a recipe.

    Args:
        recipe: The resolved recipe as the manifest holds it; one that says nothing about sensors has the usual ones.
    """
    rig, kinds = recorded_rig(recipe), dict(KITTI_KINDS)
    if rig.baseline is not None:
        kinds |= _STEREO_KINDS | (_MATCHED_KINDS if rig.matched else {})
    if rig.clean:
        kinds |= _CLEAN_KINDS | (_CLEAN_STEREO_KINDS if rig.baseline is not None else {})
    for name in rig.lidars:
        kinds |= {f"velodyne_{name}": "bin", f"velodyne_{name}_ids": "bin"}
    return kinds | ({"calib_lidars": "txt"} if rig.lidars else {})


def _ending(kind: str) -> str:
    known = KITTI_KINDS | _STEREO_KINDS | _MATCHED_KINDS | _CLEAN_KINDS | _CLEAN_STEREO_KINDS | {"calib_lidars": "txt"}
    return "bin" if kind.startswith("velodyne_") else known[kind]
