"""What is under test, of this package or made by others, and what all its checks ask of it."""

import copy
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Self, TypeVar

import numpy as np
from jaxtyping import Float32

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.formats import FORMATS, FormatReader, dataset_format, has_depth
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.dataset.reader import open_format
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS, Split, parts_of
from warehouse_sim.dataset.stored.scene_record import SceneRecord, read_scene_record
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import Transform

_KEPT_IMAGES = 64
T = TypeVar("T")
R = TypeVar("R")


class Examined:
    """A folder under test.

    Args:
        root: The folder.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self.progress: Callable[[float], None] = lambda fraction: None
        """Called with the fraction (0-1) of a check's work that is done."""

    def each(self, items: Sequence[T], examine: Callable[[T], R]) -> Iterator[R]:
        """Yield what ``examine`` says of each item, in order, and report the progress.

        Items are examined side by side in threads: most of the work is in libraries that let others run meanwhile.
        """
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            for done, result in enumerate(pool.map(examine, items), start=1):
                yield result
                self.progress(done / len(items))


class Subject(Examined):
    """A dataset with a readable manifest, seen through one of its formats.

    Args:
        root: Folder of the dataset.
        manifest: Its manifest.
    """

    def __init__(self, root: Path, manifest: Manifest) -> None:
        super().__init__(root)
        self.manifest = manifest
        self.layout = DatasetLayout(root)
        self._records: dict[int, SceneRecord] = {}
        self._format: str | None = None
        self._of_format: dict[str, Subject] = {}

    def of_format(self, name: str) -> "Subject":
        """Return the same dataset as the files of one format show it; records are shared."""
        if name not in self._of_format:
            other = copy.copy(self)
            for kept in ("reader", "depth", "objects"):
                vars(other).pop(kept, None)
            other._format = name
            self._of_format[name] = other
        self._of_format[name].progress = self.progress
        return self._of_format[name]

    @cached_property
    def reader(self) -> FormatReader | None:
        """What training and scoring see of the format's files, or of the first format that they can read, if any."""
        return open_format(self.root, self.manifest.formats if self._format is None else (self._format,))

    @property
    def readable(self) -> FormatReader:
        """The reader, which the format must have.

        Raises:
            DatasetError: It has none.
        """
        if self.reader is None:
            raise DatasetError(f"{self.root}: the format {self._format} has no reader")
        return self.reader

    @cached_property
    def depth(self) -> Callable[[ImageRecord], Float32[np.ndarray, "h w"]]:
        """Read an image's depth (m), 0 = no reading; the images of a small dataset are decoded once for all checks."""
        return lru_cache(_KEPT_IMAGES)(self.readable.depth)

    @cached_property
    def objects(self) -> Mapping[int, ObjectInfo]:
        """The objects of objects.json by obj_id, with their meshes if a format has them."""
        return read_objects(self.root) if self.reader is None else self.reader.objects

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

    def put_together(self, items: Sequence[T], examine: Callable[[T], Findings]) -> Findings:
        """Return what ``examine`` has found in all items, which are looked at as ``each`` does."""
        findings = Findings()
        for part in self.each(items, examine):
            findings.add(part)
        return findings

    def scenes(self) -> Iterator[tuple[Split, int]]:
        """Yield every scene with its split."""
        for split in SPLITS:
            for index in self.manifest.splits[split]:
                yield split, index

    def observations(self) -> Iterator[tuple[Split, int, int]]:
        """Yield split, scene and observation of every observation."""
        for split, scene in self.scenes():
            for observation in range(self.manifest.observations_per_scene):
                yield split, scene, observation

    def images(self) -> Iterator[ImageRecord]:
        """Yield every image that the format's reader has."""
        for split in SPLITS:
            yield from self.readable.images(split)


class ThirdPartySubject(Examined):
    """A folder that a known format recognises.

    Args:
        root: The folder.
        format_name: Name of that format.
        reader: What reads it.
    """

    def __init__(self, root: Path, format_name: str, reader: FormatReader) -> None:
        super().__init__(root)
        self.format_name, self.reader = format_name, reader

    @classmethod
    def of(cls, root: Path) -> Self:
        """Open a folder.

        Raises:
            DatasetError: No known format recognises it.
        """
        for name in FORMATS.names():
            reader = open_format(root, [name]) if dataset_format(name).recognises(root) else None
            if reader is not None:
                return cls(root, name, reader)
        raise DatasetError(f"{root}: is a dataset of none of the known formats: {', '.join(FORMATS.names())}")

    @cached_property
    def lacks(self) -> frozenset[str]:
        """What the folder has none of: "depth", "masks", "ground-truth masks", "amodal masks", "meshes", "colour"."""
        has_meshes = any(info.has_mesh for info in self.reader.objects.values())
        found = {"meshes": has_meshes, "depth": has_depth(self.reader)}
        return frozenset(getattr(self.reader, "lacks", ())) | {name for name, there in found.items() if not there}

    @cached_property
    def images(self) -> list[ImageRecord]:
        """Every image of every split, once.

        Raises:
            DatasetError: A table is missing or malformed.
        """
        return [image for split in parts_of(self.reader.splits) for image in self.reader.images(split)]

    def where(self, image: ImageRecord) -> str:
        """Name an image."""
        return f"{self.root}: {image.split} scene {image.scene_id}, image {image.image_id}"
