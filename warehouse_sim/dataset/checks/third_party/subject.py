"""A dataset without a manifest, as its format's reader shows it."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from pathlib import Path
from typing import Self, TypeVar

from warehouse_sim.dataset.formats import FORMATS, FormatReader, dataset_format, has_depth
from warehouse_sim.dataset.reader import open_format
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError

T = TypeVar("T")
R = TypeVar("R")


class ThirdPartySubject:
    """A folder that a known format recognises.

    Args:
        root: The folder.
        format_name: Name of that format.
        reader: What reads it.
    """

    def __init__(self, root: Path, format_name: str, reader: FormatReader) -> None:
        self.root, self.format_name, self.reader = root, format_name, reader
        self.progress: Callable[[float], None] = lambda fraction: None
        """Called with the fraction (0-1) of a check's work that is done."""

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
        has_meshes = any(info.has_cad and info.read_mesh is not None for info in self.reader.objects.values())
        found = {"meshes": has_meshes, "depth": has_depth(self.reader)}
        return frozenset(getattr(self.reader, "lacks", ())) | {name for name, there in found.items() if not there}

    @cached_property
    def images(self) -> list[ImageRecord]:
        """Every image of every split.

        Raises:
            DatasetError: A table is missing or malformed.
        """
        return [image for split in self.reader.splits for image in self.reader.images(split)]

    def each(self, items: Sequence[T], examine: Callable[[T], R]) -> Iterator[R]:
        """Yield what ``examine`` says of each item, in order, and report the progress; items run side by side."""
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            for done, result in enumerate(pool.map(examine, items), start=1):
                yield result
                self.progress(done / len(items))

    def where(self, image: ImageRecord) -> str:
        """Name an image."""
        return f"{self.root}: {image.split} scene {image.scene_id}, image {image.image_id}"
