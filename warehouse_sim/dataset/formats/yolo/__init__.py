"""The YOLO format as Ultralytics reads it (docs.ultralytics.com/datasets): boxes, polygons, key points, oriented boxes.

All four are always written, each a data set of its own, since one label file has rows of one kind; images are hard
links.
"""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import DatasetWriter, FormatReader
from warehouse_sim.dataset.formats.yolo.layout import NAME
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest


class YoloFormat:
    """Images and text files of labels, a folder a task."""

    name = NAME

    @property
    def checks(self) -> Sequence[NamedCheck]:
        """Checks of its files, and of them against those of BOP."""
        from warehouse_sim.dataset.formats.yolo.checks import CHECKS

        return CHECKS

    def reject(self, manifest: Manifest) -> None:
        """Reject nothing: boxes and masks are there in every observation."""

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into ``root/yolo``."""
        from warehouse_sim.dataset.formats.yolo.writer import YoloWriter

        return YoloWriter(root, manifest)

    def reader(self, root: Path) -> FormatReader | None:
        """Return a reader of a third-party folder; None of a dataset of ours: nothing in it is only here."""
        if DatasetLayout(root).manifest.is_file() or not self.recognises(root):
            return None
        from warehouse_sim.dataset.formats.yolo.reader import YoloReader

        return YoloReader(root)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder holds a data.yaml."""
        return (root / "data.yaml").is_file()


FORMAT = YoloFormat()
