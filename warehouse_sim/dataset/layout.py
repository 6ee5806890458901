"""Where everything lies in a dataset folder, whatever its formats; the one place that knows file names."""

from dataclasses import dataclass
from pathlib import Path


def observation_name(scene_index: int, observation: int) -> str:
    """Return the name of the files of an observation in folders that hold those of several scenes."""
    return f"{scene_index:06d}_{observation:06d}"


@dataclass(frozen=True)
class DatasetLayout:
    """Paths of what every dataset has, whatever its formats."""

    root: Path

    @property
    def manifest(self) -> Path:
        """The file that is written last: its presence says that the dataset is complete."""
        return self.root / "manifest.json"

    @property
    def readme(self) -> Path:
        """The card: what the dataset is, for people."""
        return self.root / "README.md"

    @property
    def card(self) -> Path:
        """Folder of what the card shows: thumbnails and the resolved recipe."""
        return self.root / "card"

    @property
    def recipe(self) -> Path:
        """The resolved recipe, as ``generate`` takes it."""
        return self.card / "recipe.yaml"

    @property
    def unfinished(self) -> Path:
        """The manifest of a dataset that is still being made."""
        return self.root / "manifest.unfinished.json"

    @property
    def shard(self) -> Path:
        """In the folder of a shard, which one of how many it is."""
        return self.root / "shard.json"

    @property
    def objects(self) -> Path:
        """What is known of each CAD geometry."""
        return self.root / "objects.json"

    @property
    def scenes(self) -> Path:
        """Folder of the scene records."""
        return self.root / "scenes"

    def scene_record(self, scene_index: int) -> Path:
        """Return the record of a scene, written last of all its files."""
        return self.scenes / f"{scene_index:06d}.json"

    @property
    def damaged(self) -> Path:
        """Folder of the surfaces of damaged objects, which differ from the CAD surface of their obj_id."""
        return self.root / "damaged"

    def damaged_mesh(self, model: str) -> Path:
        """Return the surface (mm) of a damaged object by the name of its model."""
        return self.damaged / f"{model}.ply"

    def format_folder(self, name: str) -> Path:
        """Return the folder of a dataset format."""
        return self.root / name

    @property
    def readings(self) -> Path:
        """Folder of what sensors read that no format holds."""
        return self.root / "readings"

    def reading(self, sensor: str, scene_index: int, observation: int) -> Path:
        """Return the file of what a sensor that no format holds read at one observation."""
        return self.readings / sensor / f"{observation_name(scene_index, observation)}.npz"
