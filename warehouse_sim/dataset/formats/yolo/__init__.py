"""The YOLO format as Ultralytics reads it (docs.ultralytics.com/datasets): boxes, polygons, key points, oriented boxes.

All four are always written, each a data set of its own, since one label file has rows of one kind; images are hard
links.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.layout import DatasetLayout

NAME = "yolo"
"""Of the format and of its folder in a dataset."""
Task = Literal["detect", "segment", "pose", "obb"]
"""What labels are of: boxes, polygons, key points, oriented boxes."""
TASKS: tuple[Task, ...] = get_args(Task)


@dataclass(frozen=True)
class YoloLayout:
    """Paths of the data set of one task; labels are found by taking ``labels`` for the last ``images`` of a path."""

    root: Path

    @property
    def data(self) -> Path:
        """Names of the classes and places of the splits."""
        return self.root / "data.yaml"

    def images(self, split: str) -> Path:
        """Return the folder of the images of a split."""
        return self.root / "images" / split

    def labels(self, split: str) -> Path:
        """Return the folder of the labels of a split."""
        return self.root / "labels" / split


def yolo_layout(root: Path, task: Task) -> YoloLayout:
    """Return the paths of one task of a dataset."""
    return YoloLayout(DatasetLayout(root).format_folder(NAME) / task)


def external_folder(root: Path) -> Path | None:
    """Return ``root`` or the folder of a task in it, that with the most in its rows; None if none has a data.yaml."""
    folders = (root, *(root / task for task in ("segment", "detect", "obb", "pose")))
    return next((path for path in folders if YoloLayout(path).data.is_file()), None)


class YoloFormat(BuiltIn):
    """Images and text files of labels, a folder a task."""

    def reader(self, root: Path) -> FormatReader | None:
        """Return a reader of a third-party folder; None of a dataset of ours: nothing in it is only here."""
        folder = None if DatasetLayout(root).manifest.is_file() else external_folder(root)
        if folder is None:
            return None
        from warehouse_sim.dataset.formats.yolo.reader import YoloReader

        return YoloReader(folder)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder, or that of a task in it, holds a data.yaml."""
        return external_folder(root) is not None


FORMAT = YoloFormat(
    NAME,
    checks_at="warehouse_sim.dataset.formats.yolo.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.yolo.writer:YoloWriter",
    needs=("rgb", "masks", "poses"),
    holds=("rgb", "masks", "poses"),
    counts=("depth",),
)
