"""Where everything lies in a COCO folder, and the numbers of its images."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.stored.contents import Contents

NAME = "coco"
"""Of the format and of its folder in a dataset."""
Table = Literal["instances", "instances_amodal", "panoptic"]
"""What a table of annotations holds."""
TABLES: tuple[Table, ...] = ("instances", "instances_amodal", "panoptic")


def tables_of(contents: Contents) -> list[Table]:
    """Return the tables of a dataset; that of amodal masks is left out with them."""
    return [name for name in TABLES if name != "instances_amodal" or "amodal_masks" in contents.outputs]


IMAGES = "images"
"""The part of a scene that every table of its split begins with."""


@dataclass(frozen=True)
class CocoLayout:
    """Paths of a COCO dataset."""

    root: Path

    @property
    def annotations(self) -> Path:
        """Folder of the tables."""
        return self.root / "annotations"

    def table(self, name: Table, split: str) -> Path:
        """Return a table of a split."""
        return self.annotations / f"{name}_{split}.json"

    def segments(self, split: str) -> Path:
        """Return the folder of the images of segment ids of a split."""
        return self.annotations / f"panoptic_{split}"

    def images(self, split: str) -> Path:
        """Return the folder of the images of a split."""
        return self.root / split

    def part(self, scene_index: int, name: str) -> Path:
        """Return what one scene adds to the tables of its split: one of ``TABLES``, or ``IMAGES``."""
        return self.root / "parts" / f"{scene_index:06d}" / f"{name}.json"


def coco_layout(root: Path) -> CocoLayout:
    """Return the paths of the COCO files of a dataset."""
    return CocoLayout(DatasetLayout(root).format_folder(NAME))


def image_number(manifest: Manifest, scene_index: int, observation: int) -> int:
    """Return the number of an image, the same as that of its KITTI frame."""
    return scene_index * manifest.observations_per_scene + observation
