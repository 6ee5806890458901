"""MCAP, the container of robots' recordings, with Foxglove's schemas: for playing a scene back in time."""

from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.optional import require_extra

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


class McapFormat(BuiltIn):
    """One file a scene; it is for looking and playing back, not for training: a recording has no masks."""

    def reject(self, manifest: Manifest) -> None:
        """Reject an installation without the packages that write it.

        Raises:
            MissingPackageError: The extra is not installed.
        """
        require_extra("mcap", "to write the format mcap")


FORMAT = McapFormat(
    NAME,
    checks_at="warehouse_sim.dataset.formats.mcap.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.mcap.writer:McapWriter",
    needs=("rgb", "depth", "poses"),
    holds=("rgb", "depth", "poses", "lidar", "right"),
)
