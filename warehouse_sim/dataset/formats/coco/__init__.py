"""The COCO format: instances, amodal instances and panoptic segmentation, https://cocodataset.org/#format-data.

Instances, amodal instances and panoptic are always all written: the images, hard links, are most of a dataset, and a
format is named in the manifest without options.
"""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import DatasetWriter, FormatReader
from warehouse_sim.dataset.formats.coco.layout import NAME
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest


class CocoFormat:
    """Images and JSON tables of boxes and masks, a table a split."""

    name = NAME

    @property
    def checks(self) -> Sequence[NamedCheck]:
        """Checks of its files, and of them against those of BOP."""
        from warehouse_sim.dataset.formats.coco.checks import CHECKS

        return CHECKS

    def reject(self, manifest: Manifest) -> None:
        """Reject nothing: boxes and masks are there in every observation."""

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into ``root/coco``."""
        from warehouse_sim.dataset.formats.coco.writer import CocoWriter

        return CocoWriter(root, manifest)

    def reader(self, root: Path) -> FormatReader:
        """Return a reader of ``root/coco``, or of a third-party folder."""
        from warehouse_sim.dataset.formats.coco.reader import CocoReader
        from warehouse_sim.dataset.objects import read_objects

        layout = DatasetLayout(root)
        if layout.manifest.is_file():
            return CocoReader(layout.format_folder(NAME), read_objects(root))
        return CocoReader(root)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder holds tables of instances."""
        from warehouse_sim.dataset.formats.coco.reader import find_tables

        return bool(find_tables(root))


FORMAT = CocoFormat()
