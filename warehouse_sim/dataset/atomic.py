"""Files appear whole or not at all: written under a temporary name in the same folder, then renamed."""

import os
from pathlib import Path

from warehouse_sim.errors import DatasetError

_TEMPORARY = ".part"


def write_bytes(path: Path, data: bytes, durable: bool = False) -> None:
    """Write ``data`` to ``path`` in one step; an existing file is replaced.

    Args:
        path: File to make; its folder must exist.
        data: The whole content.
        durable: Force the data to the disk before the rename. Bulk files go without, for speed: a killed process
            loses nothing by that, and what a power cut takes is found by ``warehouse-sim validate``.

    Raises:
        DatasetError: The file cannot be written.
    """
    temporary = _temporary(path)
    try:
        with open(temporary, "wb") as file:
            file.write(data)
            if durable:
                file.flush()
                os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as problem:
        temporary.unlink(missing_ok=True)
        raise DatasetError(
            f"{path}: cannot be written ({problem.strerror}); check the folder and the free space"
        ) from problem


def share_file(source: Path, path: Path, data: bytes) -> None:
    """Make ``path`` a second name of ``source``, which holds ``data``; a copy where the disk has no hard links."""
    temporary = _temporary(path)
    temporary.unlink(missing_ok=True)
    try:
        os.link(source, temporary)
    except OSError:
        write_bytes(path, data)
        return
    os.replace(temporary, path)


def remove_temporaries(root: Path) -> None:
    """Delete what a killed run left behind under ``root``."""
    for path in root.rglob(f".*{_TEMPORARY}"):
        path.unlink()


def _temporary(path: Path) -> Path:
    # The process number keeps two processes apart that write the same shared file.
    return path.with_name(f".{path.name}.{os.getpid()}{_TEMPORARY}")
