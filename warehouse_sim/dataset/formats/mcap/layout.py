"""Where the files of a dataset's scenes lie, and how their topics and frames are called."""

from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.dataset.layout import DatasetLayout

NAME = "mcap"
"""Of the format and of its folder in a dataset."""
WORLD, RIG = "world", "rig"
"""Frames beside those of the sensors, which bear the sensors' names."""
TRANSFORMS, OBJECTS, CONDITIONS = "/tf", "/objects", "/conditions"
IMAGE, DEPTH, CALIBRATION, BOXES, POINTS, READING = "image", "depth", "calibration", "boxes", "points", "reading"
"""Topics of a sensor."""


def topic(sensor: str, what: str) -> str:
    """Return the topic of what a sensor gives: ``/camera/image``."""
    return f"/{sensor}/{what}"


@dataclass(frozen=True)
class McapLayout:
    """Paths of the MCAP files of a dataset."""

    root: Path

    def scene(self, split: str, scene_index: int) -> Path:
        """Return the file of a scene."""
        return self.root / split / f"{scene_index:06d}.mcap"


def mcap_layout(root: Path) -> McapLayout:
    """Return the paths of the MCAP files of a dataset."""
    return McapLayout(DatasetLayout(root).format_folder(NAME))
