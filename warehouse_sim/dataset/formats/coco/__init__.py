"""The COCO format: instances, amodal instances and panoptic segmentation, https://cocodataset.org/#format-data.

Instances, amodal instances and panoptic are all written, amodal ones unless their masks are left out: the images, hard
links, are most of a dataset, and a format is named in the manifest without options.
"""

from pathlib import Path

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.formats.coco.layout import NAME
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.objects import read_objects


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
)
