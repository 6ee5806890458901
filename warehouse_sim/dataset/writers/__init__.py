"""Dataset formats: each writer stores the same observations in the layout that its ecosystem reads."""

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from warehouse_sim.dataset.frame_files import ObservationFiles
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.registry import Registry
from warehouse_sim.schema import ObjectModel

WRITERS = Registry("dataset format")
WRITERS.add("bop", "warehouse_sim.dataset.writers.bop:BopWriter")
WRITERS.add("kitti", "warehouse_sim.dataset.writers.kitti:KittiWriter")


class SceneWriter(Protocol):
    """Writes the observations of one scene, in order."""

    def write(self, files: ObservationFiles) -> None:
        """Store one observation.

        Raises:
            DatasetError: The format cannot hold it.
        """

    def finish(self) -> None:
        """Store what covers the whole scene."""


class DatasetWriter(Protocol):
    """One format; built anew in every process, so it holds nothing but where and what to write."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        """Take the dataset's folder; the format's own files go into the folder of its name.

        Nothing is written yet: this is where a format refuses what it cannot hold at all.

        Raises:
            DatasetError: Names the setting of the manifest, or of its recipe, that asks for it.
        """

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Store what all scenes share; called once, before any scene.

        Args:
            models: Every geometry that a label can name.
            camera: The rig's camera.
        """

    def scene(self, scene_index: int) -> SceneWriter:
        """Open a scene, removing what an interrupted run left of it.

        Scenes are written in any order, by several processes at once: no file belongs to two scenes.
        """

    def finish(self) -> None:
        """Store what needs all scenes; called once, after the last scene."""
