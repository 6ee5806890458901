"""One of several runs that make a dataset together, each in a folder of its own: every n-th scene is its."""

import re
import tarfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any

from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.errors import ConfigError, DatasetError, InputError, shown
from warehouse_sim.optional import require
from warehouse_sim.ranges import Range, ranged


def packed_name(index: int) -> str:
    """Return the name of the archive of a shard."""
    return f"shard-{index:06d}.tar"


def stored_shards(place: str) -> list[str]:
    """Return the names of the archives that a folder, such as ``s3://bucket/data``, holds, sorted.

    Raises:
        DatasetError: The place cannot be read.
    """
    files, root = _open(place)
    with _reaching(f"{place}: cannot be read", ""):
        # What is remembered of a folder does not know what others have stored there since.
        files.invalidate_cache()
        found = files.ls(root, detail=False) if files.exists(root) else []
    names = (str(path).rstrip("/").rpartition("/")[2] for path in found)
    return sorted(name for name in names if name.startswith("shard-") and name.endswith(".tar"))


def pack_shard(folder: Path, place: str, name: str) -> None:
    """Store all files of a folder as the archive ``name``; readers see it when it is complete, and not before.

    Raises:
        DatasetError: It cannot be written.
    """
    files, root = _open(place)
    with _reaching(f"{place}/{name}: cannot be written", ""):
        files.makedirs(root, exist_ok=True)
        with (
            files.transaction,
            files.open(f"{root}/{name}", "wb") as stream,
            tarfile.open(fileobj=stream, mode="w") as archive,
        ):
            for path in sorted(item for item in folder.rglob("*") if item.is_file()):
                archive.add(path, str(path.relative_to(folder)), recursive=False)


def unpack_shard(place: str, name: str, folder: Path) -> None:
    """Put the files of an archive into a folder; nothing leaves it.

    Raises:
        DatasetError: The archive cannot be read.
    """
    files, root = _open(place)
    with (
        _reaching(f"{place}/{name}: cannot be read", "; make the shard again"),
        files.open(f"{root}/{name}", "rb") as stream,
        tarfile.open(fileobj=stream, mode="r:") as archive,
    ):
        archive.extractall(folder, filter="data")


@contextmanager
def _reaching(what: str, remedy: str) -> Iterator[None]:
    """Say in one line what a place answers: its library raises errors of its own, which only it knows by name.

    Raises:
        DatasetError: Anything went wrong in the block.
    """
    try:
        yield
    except Exception as problem:
        raise DatasetError(f"{what} ({problem}){remedy}") from problem


def _open(place: str) -> tuple[Any, str]:
    """Return the file system of a place and the path there."""
    fsspec: ModuleType = require("fsspec", "cluster", "to keep shards in places of fsspec")
    files, root = fsspec.core.url_to_fs(place)
    return files, str(root).rstrip("/")


@dataclass(frozen=True)
@ranged
class Shard:
    """The scenes whose index leaves ``index`` when divided by ``count``: near ones, which are alike, are spread."""

    index: Annotated[int, Range(0, 999_999)]
    """Which of them, 0-999,999 and below ``count``, as job arrays number their tasks."""
    count: Annotated[int, Range(1, 1_000_000)]
    """How many there are, 1-1,000,000."""

    def __post_init__(self) -> None:
        if not 0 <= self.index < self.count:
            raise ValueError(f"of {self.count} shards there is no {self.index}; they are 0 to {self.count - 1}")

    def __str__(self) -> str:
        return f"{self.index}/{self.count}"

    def scenes(self, total: int) -> range:
        """Return its scenes in a dataset of ``total``."""
        return range(self.index, total, self.count)


def parse_shard(text: str) -> Shard:
    """Return the shard that ``text`` names, such as 0/4.

    Raises:
        InputError: It names none.
    """
    if not re.fullmatch(r"[0-9]{1,7}/[0-9]{1,7}", text):
        raise InputError(f"--shard {shown(text)}: must be i/n, such as 0/4 for the first of four")
    index, count = map(int, text.split("/"))
    try:
        return Shard(index, count)
    except (ValueError, ConfigError) as problem:
        raise InputError(f"--shard {text}: {problem}") from problem


def write_shard(root: Path, shard: Shard) -> None:
    """Say of a folder that it is a shard."""
    write_json(DatasetLayout(root).shard, to_mapping(shard))


def read_shard(root: Path) -> Shard | None:
    """Return which shard a folder is; None where it is none.

    Raises:
        DatasetError: The file that says so is malformed.
    """
    path = DatasetLayout(root).shard
    if not path.is_file():
        return None
    try:
        return from_mapping(Shard, read_json(path), str(path))
    except ConfigError as problem:
        raise DatasetError(str(problem)) from problem
