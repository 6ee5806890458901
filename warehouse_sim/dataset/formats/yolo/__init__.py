"""The YOLO format as Ultralytics reads it (docs.ultralytics.com/datasets): boxes, polygons, key points, oriented boxes.

All four are always written, each a data set of its own, since one label file has rows of one kind; images are hard
links.
"""

from pathlib import Path

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.formats.yolo.layout import NAME
from warehouse_sim.dataset.layout import DatasetLayout


class YoloFormat(BuiltIn):
    """Images and text files of labels, a folder a task."""

    def reader(self, root: Path) -> FormatReader | None:
        """Return a reader of a third-party folder; None of a dataset of ours: nothing in it is only here."""
        if DatasetLayout(root).manifest.is_file() or not self.recognises(root):
            return None
        from warehouse_sim.dataset.formats.yolo.reader import YoloReader

        return YoloReader(root)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder holds a data.yaml."""
        return (root / "data.yaml").is_file()


FORMAT = YoloFormat(
    NAME,
    checks_at="warehouse_sim.dataset.formats.yolo.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.yolo.writer:YoloWriter",
    needs=("rgb", "masks", "poses"),
    holds=("rgb", "masks", "poses"),
)
