"""How many bytes a dataset takes, by folder: what was written is measured, nothing is estimated."""

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class DiskUse:
    """Bytes of some folders."""

    by_folder: dict[str, int]
    """Folder -> bytes of its files, were it copied alone; what is linked within it counts once."""
    together: int
    """Bytes of all folders, where files that formats share as links count once."""


def measure(root: Path, folders: Iterable[str]) -> DiskUse:
    """Measure folders of a dataset; those that do not exist are left out.

    Args:
        root: Folder of the dataset.
        folders: Names in it.
    """
    by_folder: dict[str, int] = {}
    linked: set[tuple[int, int]] = set()
    together = 0
    for name in (name for name in folders if (root / name).is_dir()):
        own: set[tuple[int, int]] = set()
        by_folder[name] = 0
        for status in _files(root / name):
            key = status.st_dev, status.st_ino
            by_folder[name] += 0 if key in own else status.st_size
            together += 0 if key in own or key in linked else status.st_size
            if status.st_nlink > 1:
                own.add(key)
        linked |= own
    return DiskUse(by_folder, together)


def _files(folder: Path) -> Iterator[os.stat_result]:
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                yield from _files(Path(entry.path))
            elif entry.is_file(follow_symlinks=False):
                yield entry.stat(follow_symlinks=False)
