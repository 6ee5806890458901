"""A shard as one tar archive at any place that fsspec knows: there whole or not at all."""

import tarfile
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
    try:
        found = files.ls(root, detail=False) if files.exists(root) else []
    except OSError as problem:
        raise DatasetError(f"{place}: cannot be read ({problem})") from problem
    names = (str(path).rstrip("/").rpartition("/")[2] for path in found)
    return sorted(name for name in names if name.startswith("shard-") and name.endswith(".tar"))


def pack_shard(folder: Path, place: str, name: str) -> None:
    """Store all files of a folder as the archive ``name``; readers see it when it is complete, and not before.

    Raises:
        DatasetError: It cannot be written.
    """
    files, root = _open(place)
    try:
        files.makedirs(root, exist_ok=True)
        with (
            files.transaction,
            files.open(f"{root}/{name}", "wb") as stream,
            tarfile.open(fileobj=stream, mode="w") as archive,
        ):
            for path in sorted(item for item in folder.rglob("*") if item.is_file()):
                archive.add(path, str(path.relative_to(folder)), recursive=False)
    except OSError as problem:
        raise DatasetError(f"{place}/{name}: cannot be written ({problem})") from problem


def unpack_shard(place: str, name: str, folder: Path) -> None:
    """Put the files of an archive into a folder; nothing leaves it.

    Raises:
        DatasetError: The archive cannot be read.
    """
    files, root = _open(place)
    try:
        with files.open(f"{root}/{name}", "rb") as stream, tarfile.open(fileobj=stream, mode="r:") as archive:
            archive.extractall(folder, filter="data")
    except (OSError, tarfile.TarError) as problem:
        raise DatasetError(f"{place}/{name}: cannot be read ({problem}); make the shard again") from problem


def _open(place: str) -> tuple[Any, str]:
    """Return the file system of a place and the path there."""
    fsspec: ModuleType = require("fsspec", "cluster", "to keep shards in places of fsspec")
    files, root = fsspec.core.url_to_fs(place)
    return files, str(root).rstrip("/")
