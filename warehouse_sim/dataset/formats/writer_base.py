"""What writers have in common: where and what to write, and how an interrupted run's leftovers are removed."""

import shutil
from functools import cached_property
from pathlib import Path

from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.output import writing


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
