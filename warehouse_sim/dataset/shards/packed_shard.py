"""A shard as one tar archive at any place that fsspec knows: there whole or not at all."""

import tarfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

from warehouse_sim.errors import DatasetError
from warehouse_sim.optional import require


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
