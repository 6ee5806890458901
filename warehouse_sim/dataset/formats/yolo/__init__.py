"""The YOLO format as Ultralytics reads it (docs.ultralytics.com/datasets): boxes, polygons, key points, oriented boxes.

All four are always written, each a data set of its own, since one label file has rows of one kind; images are hard
links.
"""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import DatasetWriter
from warehouse_sim.dataset.formats.yolo.layout import NAME
from warehouse_sim.dataset.manifest import Manifest


class YoloFormat:
    """Images and text files of labels, a folder a task."""

    name = NAME

    @property
    def checks(self) -> Sequence[NamedCheck]:
        """Checks of its files."""
        return ()

    def refuse(self, manifest: Manifest) -> None:
        """Refuse nothing: boxes and masks are there in every observation."""

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into ``root/yolo``."""
        from warehouse_sim.dataset.formats.yolo.writer import YoloWriter

        return YoloWriter(root, manifest)

    def reader(self, root: Path) -> None:
        """Return nothing yet."""

    def recognises(self, root: Path) -> bool:
        """Return that no folder is read."""
        return False


FORMAT = YoloFormat()
