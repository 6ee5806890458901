"""Where everything lies in a YOLO folder: a data set of its own for each task, with names of the same images."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

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
