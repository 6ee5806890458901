"""What the formats of this package have in common: parts that are imported on use, and the bases of writers."""

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import DatasetWriter, FormatReader
from warehouse_sim.dataset.formats.observation_files import ObservationFiles, require_depth_fits
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.output import writing
from warehouse_sim.schema.outputs import Output


@dataclass(frozen=True)
class BuiltIn:
    """Base of the formats of this package: to read a dataset needs no check, to write one no reader."""

    name: str
    """As in ``--formats``, and of its folder in a dataset."""
    checks_at: str
    """Where the checks of its files are, as "module:name", as are all parts."""
    writer_at: str
    """A class that takes the dataset's folder and its manifest."""
    needs: tuple[Output, ...]
    """Outputs that it cannot do without."""
    holds: tuple[Output, ...]
    """Outputs that it has a place for, those among them."""
    counts: tuple[Output, ...] = ()
    """Outputs that its labels are counted from, stored or not."""
    third_party_checks_at: str = ""
    """Checks of third-party folders only; empty = none."""
    steps_per_metre: float | None = None
    """Of its depth images in 16 bits; None = it has no such images."""

    @property
    def checks(self) -> Sequence[NamedCheck]:
        """Checks of its files."""
        found: Sequence[NamedCheck] = _part(self.checks_at)
        return found

    @property
    def third_party_checks(self) -> Sequence[NamedCheck]:
        """Checks of third-party folders only."""
        found: Sequence[NamedCheck] = _part(self.third_party_checks_at) if self.third_party_checks_at else ()
        return found

    def reject(self, manifest: Manifest) -> None:
        """Reject depth beyond 16 bits; formats that cannot hold everything else say what they cannot."""
        if self.steps_per_metre is not None:
            require_depth_fits(manifest.contents, self.steps_per_metre, self.name)

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into the format's folder."""
        writer: DatasetWriter = _part(self.writer_at)(root, manifest)
        return writer

    def reader(self, root: Path) -> FormatReader | None:
        """Return nothing; formats that training and scoring can read return a reader."""
        return None

    def recognises(self, root: Path) -> bool:
        """Return no; formats of which third-party folders are read look at the folder."""
        return False


def _part(place: str) -> Any:
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


class WriterBase:
    """Base of writers.

    Args:
        root: Folder of the dataset.
        manifest: Of the dataset.
    """

    def __init__(self, root: Path, manifest: Manifest) -> None:
        self._root, self._manifest = root, manifest

    def finish(self) -> None:
        """Store nothing; formats with files that need all scenes store them."""

    @cached_property
    def _objects(self) -> dict[int, ObjectInfo]:
        return read_objects(self._root)


class SceneWriterBase:
    """Base of what writes the observations of one scene."""

    def finish(self) -> None:
        """Store nothing; formats with files that cover a scene store them."""


@dataclass(frozen=True)
class EachWriter(SceneWriterBase):
    """Writes each observation by itself."""

    write: Callable[[ObservationFiles], None]
    """Stores one."""


def remove_folder(path: Path) -> None:
    """Delete a folder, if there is one.

    Raises:
        OutputError: It cannot be deleted.
    """
    if path.exists():
        with writing(path):
            shutil.rmtree(path)


def remove_file(path: Path) -> None:
    """Delete a file, if there is one.

    Raises:
        OutputError: It cannot be deleted.
    """
    with writing(path):
        path.unlink(missing_ok=True)
