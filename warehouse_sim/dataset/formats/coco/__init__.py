"""The COCO format: instances, amodal instances and panoptic segmentation, https://cocodataset.org/#format-data.

Instances, amodal instances and panoptic are all written, amodal ones unless their masks are left out: the images, hard
links, are most of a dataset, and a format is named in the manifest without options.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.objects import read_objects
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


class CocoFormat(BuiltIn):
    """Images and JSON tables of boxes and masks, a table a split."""

    def reader(self, root: Path) -> FormatReader:
        """Return a reader of ``root/coco``, or of a third-party folder."""
        from warehouse_sim.dataset.formats.coco.reader import CocoReader

        layout = DatasetLayout(root)
        if layout.manifest.is_file():
            return CocoReader(layout.format_folder(NAME), read_objects(root))
        return CocoReader(root)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder holds tables of instances."""
        from warehouse_sim.dataset.formats.coco.reader import find_tables

        return bool(find_tables(root))


FORMAT = CocoFormat(
    NAME,
    checks_at="warehouse_sim.dataset.formats.coco.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.coco.writer:CocoWriter",
    needs=("rgb", "masks", "poses"),
    holds=("rgb", "masks", "amodal_masks", "poses"),
    counts=("depth",),
)
