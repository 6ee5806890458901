"""Where everything lies in a folder of clouds."""

from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.dataset.layout import DatasetLayout


@dataclass(frozen=True)
class CloudLayout:
    """Paths of the clouds of a dataset in one encoding."""

    root: Path
    ending: str
    """Of a cloud's file, which is the format's name, too."""

    def scene(self, split: str, scene_index: int) -> Path:
        """Return the folder of a scene."""
        return self.root / split / f"{scene_index:06d}"

    def cloud(self, split: str, scene_index: int, observation: int, sensor: str) -> Path:
        """Return the cloud of a sensor by its name in the rig."""
        return self.scene(split, scene_index) / f"{observation:06d}_{sensor}.{self.ending}"

    def description(self, split: str, scene_index: int, observation: int) -> Path:
        """Return the poses, the calibration and the classes of an observation."""
        return self.scene(split, scene_index) / f"{observation:06d}.json"


def cloud_layout(root: Path, name: str) -> CloudLayout:
    """Return the paths of the clouds of a dataset; the format's name is the files' ending."""
    return CloudLayout(DatasetLayout(root).format_folder(name), name)
