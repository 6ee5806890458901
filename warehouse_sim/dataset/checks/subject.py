"""The dataset under test and what a check has found."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TypeVar

import numpy as np
from jaxtyping import Float32

from warehouse_sim.dataset.layout import BopLayout, DatasetLayout, KittiLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.recorded_rig import RecordedRig, recorded_rig
from warehouse_sim.dataset.scene_record import SceneRecord, read_scene_record
from warehouse_sim.dataset.split import SPLITS, Split
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import Transform

_KEPT = 100
"""Problems that a check keeps: a folder can hold more wrong files than memory."""
_KEPT_IMAGES = 64
T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Check:
    """The outcome of one check."""

    name: str
    ok: bool
    detail: str
    """What was examined, or the first thing that is wrong."""


@dataclass
class Findings:
    """Collects what is wrong while a check runs."""

    examined: str = ""
    """What was looked at, with its number."""
    problems: list[str] = field(default_factory=list)
    """The first ones that are wrong."""
    more: int = 0
    """How many were found beyond them."""
    count: int = 0
    """Number of what was looked at, where parts of a check are put together."""

    def require(self, holds: bool, problem: str) -> bool:
        """Note ``problem`` unless ``holds``; return ``holds``."""
        if not holds and len(self.problems) < _KEPT:
            self.problems.append(problem)
        elif not holds:
            self.more += 1
        return holds

    def add(self, part: "Findings") -> None:
        """Take over what a part of the check has found."""
        for problem in part.problems:
            self.require(False, problem)
        self.more += part.more
        self.count += part.count


class Subject:
    """A dataset with a readable manifest, and what the checks share of it.

    Args:
        root: Folder of the dataset.
        manifest: Its manifest.
    """

    def __init__(self, root: Path, manifest: Manifest) -> None:
        self.root, self.manifest = root, manifest
        self.progress: Callable[[float], None] = lambda share: None
        """Told the share (0-1) of a check's work that is done."""
        self.layout = DatasetLayout(root)
        self.bop = BopLayout(self.layout.format_folder("bop"))
        self.kitti = KittiLayout(self.layout.format_folder("kitti"))
        self._records: dict[int, SceneRecord] = {}

    @cached_property
    def reader(self) -> DatasetReader:
        """The dataset as training and scoring see it."""
        return DatasetReader(self.root)

    @cached_property
    def rig(self) -> RecordedRig:
        """What the recipe says of the sensors."""
        return recorded_rig(self.manifest.recipe, f"{self.layout.manifest}: recipe")

    @cached_property
    def depth(self) -> Callable[[ImageRecord], Float32[np.ndarray, "h w"]]:
        """Read an image's depth (m), 0 = no reading; the images of a small dataset are decoded once for all checks."""
        return lru_cache(_KEPT_IMAGES)(self.reader.depth)

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """The objects of objects.json by obj_id."""
        return read_objects(self.root)

    def record(self, scene_index: int) -> SceneRecord:
        """Return a scene's record, read once."""
        if scene_index not in self._records:
            self._records[scene_index] = read_scene_record(self.root, scene_index)
        return self._records[scene_index]

    def info(self, obj_id: int) -> ObjectInfo:
        """Return an object by its number.

        Raises:
            DatasetError: objects.json does not list it.
        """
        if obj_id not in self.objects:
            raise DatasetError(f"{self.layout.objects}: lacks object {obj_id}, which a label or a scene record names")
        return self.objects[obj_id]

    def T_world_camera(self, scene_index: int, observation: int) -> Transform:
        """Return where the scene record has the camera of an observation.

        Raises:
            DatasetError: It has not so many observations.
        """
        poses = self.record(scene_index).T_world_camera
        if observation >= len(poses):
            raise DatasetError(f"{self.layout.scene_record(scene_index)}: has no observation {observation}")
        return poses[observation]

    def each(self, items: Sequence[T], examine: Callable[[T], R]) -> Iterator[R]:
        """Yield what ``examine`` says of each item, in order, and tell the progress.

        Items are examined side by side in threads: most of the work is in libraries that let others run meanwhile.
        """
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            for done, result in enumerate(pool.map(examine, items), start=1):
                yield result
                self.progress(done / len(items))

    def scenes(self) -> Iterator[tuple[Split, int]]:
        """Yield every scene with its split."""
        for split in SPLITS:
            for index in self.manifest.splits[split]:
                yield split, index

    def frames(self) -> Iterator[tuple[Split, int, int, int]]:
        """Yield split, scene, observation and KITTI frame number of every observation."""
        count = self.manifest.observations_per_scene
        for split, scene in self.scenes():
            for observation in range(count):
                yield split, scene, observation, scene * count + observation

    def images(self) -> Iterator[ImageRecord]:
        """Yield every image of the BOP files."""
        for split in SPLITS:
            yield from self.reader.images(split)


def compare_names(findings: Findings, folder: Path, expected: set[str], kind: str = "file") -> None:
    """Note which ``expected`` names are missing in ``folder`` and which are there beyond them."""
    found = {path.name for path in folder.iterdir()} if folder.is_dir() else set()
    for words, names in (("is missing", expected - found), ("does not belong to the dataset", found - expected)):
        for name in sorted(names):
            findings.require(False, f"{folder / name}: this {kind} {words}")
