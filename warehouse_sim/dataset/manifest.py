"""manifest.json: what a dataset is and how to make it again; written last, so that it also says "complete"."""

import os
import platform
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.split import SPLITS, Split
from warehouse_sim.dataset.stored.contents import Contents
from warehouse_sim.errors import ConfigError, DatasetError

FORMAT_VERSION = 1
BY_HAND = "by_hand"
"""Key of ``Manifest.recipe``, which says nothing but sensors, targets and viewpoints then."""
_MOST_OBSERVATIONS = 1_000_000
"""Of one scene: BOP's image numbers have six digits."""
# What can change a byte of a dataset.
_PACKAGES = (
    "warehouse-sim",
    "numpy",
    "scipy",
    "opencv-python-headless",
    "isal",
    "mujoco",
    "trimesh",
    "moderngl",
    "embreex",
    "segno",
)


@dataclass(frozen=True)
class PairedVariant:
    """Which paired variant an observation is: one group sees the same from the same place, with one thing changed."""

    group: int
    """Number of the group within the scene."""
    variant: str
    """What was changed, in a word; "base" for the first."""


@dataclass(frozen=True)
class Manifest:
    """Everything that decides a dataset's bytes, and nothing that depends on time, place or number of workers."""

    seed: int
    """Seed of the dataset, >= 0."""
    scenes: int
    """Number of scenes."""
    observations_per_scene: int
    """Number of observations of every scene, paired variants included."""
    splits: dict[str, tuple[int, ...]]
    """Scene indices of "train", "val" and "test"; those that are ``missing`` are in none."""
    formats: tuple[str, ...]
    """Dataset formats, e.g. ("kitti", "bop")."""
    targets: tuple[str, ...]
    """Class names whose objects have full labels."""
    recipe: dict[str, Any] = field(default_factory=dict)
    """The resolved recipe as plain data."""
    packages: dict[str, str] = field(default_factory=dict)
    """Versions of Python and of the packages that make the data."""
    renderers: tuple[str, ...] = ()
    """Descriptions of the renderers that drew the scenes; filled in at the end, more than one after a resume on
    another machine."""
    paired_variants: tuple[PairedVariant, ...] = ()
    """For each observation of a scene, which paired variant it is; empty when there are no paired variants."""
    backend: str = ""
    """Render backend that was requested; empty where nothing was rendered."""
    backend_options: dict[str, Any] = field(default_factory=dict)
    """Options of the render backend that were not its defaults."""
    split_table: dict[str, Any] = field(default_factory=dict)
    """Scenes, observations and targets of each split, targets also by visible fraction, distance and lux; filled in at
    the end."""
    licences: dict[str, str] = field(default_factory=dict)
    """What may be used under which licence: "data", "textures", and what users brought; empty = not stated."""
    format_version: int = FORMAT_VERSION
    """Version of the folder's layout."""
    contents: Contents = field(kw_only=True)
    """The sensors, and what else of the recipe formats, readers and checks need to know."""
    converted_from: str = ""
    """Name of the dataset made by third parties and this one holds in another format; empty = made from the recipe."""
    checksums: str = ""
    """SHA-256 of the folder's SHA256SUMS, which lists that of every file but the card; filled in at the end."""
    missing: tuple[int, ...] = ()
    """Scenes that could not be made and were left out on request; ``scenes`` counts them."""

    def __post_init__(self) -> None:
        if self.format_version != FORMAT_VERSION:
            raise ValueError(f"format_version {self.format_version} is not readable by this version of warehouse-sim")
        if self.seed < 0 or self.scenes < 1 or self.observations_per_scene < 1:
            raise ValueError(
                "seed must be >= 0 and scenes and observations_per_scene >= 1, "
                f"found {self.seed}, {self.scenes} and {self.observations_per_scene}"
            )
        if self.observations_per_scene > _MOST_OBSERVATIONS:
            raise ValueError(
                f"observations_per_scene must be {_MOST_OBSERVATIONS} at most, found {self.observations_per_scene}"
            )
        if self.paired_variants and len(self.paired_variants) != self.observations_per_scene:
            raise ValueError(
                f"paired_variants must list {self.observations_per_scene} observations, "
                f"found {len(self.paired_variants)}"
            )
        listed = sorted([*self.missing, *(index for indices in self.splits.values() for index in indices)])
        # Counted before the numbers are written out: a file of one line can claim a thousand million scenes.
        complete = len(listed) == self.scenes and listed == list(range(self.scenes))
        if sorted(self.splits) != sorted(SPLITS) or not complete:
            raise ValueError("splits must hold every scene exactly once, under train, val or test")
        if len(self.missing) == self.scenes:
            raise ValueError("every scene is missing")

    @property
    def by_hand(self) -> bool:
        """Whether its scenes were put together in Python, so that no recipe makes them again."""
        return bool(self.recipe.get(BY_HAND, False))

    @property
    def scene_indices(self) -> list[int]:
        """The scenes that there are, in order."""
        return sorted(index for indices in self.splits.values() for index in indices)

    def without(self, missing: Collection[int]) -> "Manifest":
        """Return the manifest of the dataset that lacks these scenes."""
        splits = {name: tuple(i for i in indices if i not in missing) for name, indices in self.splits.items()}
        return replace(self, splits=splits, missing=tuple(sorted(missing)))

    def split_of(self, scene_index: int) -> Split:
        """Return the split that a scene belongs to.

        Raises:
            DatasetError: The dataset has no such scene.
        """
        for name in SPLITS:
            if scene_index in self.splits[name]:
                return name
        raise DatasetError(f"scene {scene_index} is not in the dataset; it has scenes 0 to {self.scenes - 1}")


def package_versions() -> dict[str, str]:
    """Return the versions of Python and of every installed package that can change a dataset's bytes."""
    found = {name: _installed(name) for name in _PACKAGES}
    return {"python": platform.python_version()} | {name: number for name, number in found.items() if number}


@cache
def _installed(name: str) -> str:
    """Return the version of a package, empty where it is not installed; its metadata takes long to read."""
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def write_manifest(path: Path, manifest: Manifest) -> None:
    """Write a manifest atomically."""
    write_json(path, to_mapping(manifest), depth=2)


def read_manifest(root: Path) -> Manifest:
    """Read the manifest of a complete dataset.

    Raises:
        DatasetError: The folder is no dataset, is incomplete, or its manifest cannot be used.
    """
    layout = DatasetLayout(root)
    if not root.is_dir():
        raise DatasetError(f"{root}: is not a folder; make a dataset with warehouse-sim generate")
    if not layout.manifest.is_file():
        require_no_part(root)
        raise DatasetError(f"{root}: no manifest.json: this is no dataset; make one with warehouse-sim generate")
    return load_manifest(layout.manifest)


def require_no_part(root: Path) -> None:
    """Reject a folder that has no manifest and yet is of a dataset of this package: it is incomplete.

    Raises:
        DatasetError: It is one, a shard of one, or the folder of one of its formats.
    """
    layout = DatasetLayout(root)
    if layout.shard.is_file():
        raise DatasetError(
            f"{root}: no manifest.json: this is one shard of a dataset, which is incomplete; "
            "put all of them together with warehouse-sim generate --merge"
        )
    if layout.unfinished.is_file():
        if _by_hand(layout.unfinished):
            raise DatasetError(
                f"{root}: no manifest.json: the dataset is incomplete; run the script that writes it again, with "
                "ws.Writer(..., overwrite=True)"
            )
        raise DatasetError(
            f"{root}: no manifest.json: the dataset is incomplete; "
            f"resume it with warehouse-sim generate RECIPE --out {root} --resume"
        )
    if layout.objects.is_file() and layout.scenes.is_dir():
        raise DatasetError(f"{root}: no manifest.json: the dataset is incomplete; copy it or generate it again")
    # Of a link that leads to itself, too, which resolve() answers with a RuntimeError before Python 3.13.
    around = Path(os.path.realpath(root)).parent
    if DatasetLayout(around).unfinished.is_file() and not DatasetLayout(around).manifest.is_file():
        raise DatasetError(
            f"{root}: belongs to a dataset that is incomplete; "
            f"resume it with warehouse-sim generate RECIPE --out {around} --resume"
        )


def _by_hand(path: Path) -> bool:
    """Whether a manifest says that a script wrote the dataset; one that cannot be read does not say so."""
    try:
        return load_manifest(path).by_hand
    except DatasetError:
        return False


def load_manifest(path: Path) -> Manifest:
    """Read one manifest file strictly.

    Raises:
        DatasetError: The file is missing, or holds a key or value that does not belong there.
    """
    try:
        return from_mapping(Manifest, read_json(path), str(path))
    except ConfigError as problem:
        raise DatasetError(str(problem)) from problem


def dataset_around(root: Path) -> Path | None:
    """Return the complete dataset of this package that a folder is a part of, such as ``DATA`` of ``DATA/kitti``."""
    around = Path(os.path.realpath(root)).parent
    if DatasetLayout(root).manifest.is_file() or not DatasetLayout(around).manifest.is_file():
        return None
    try:
        manifest = read_manifest(around)
    except DatasetError:
        return None
    return around if Path(os.path.realpath(root)).name in manifest.formats else None
