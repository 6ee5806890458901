"""Files and folders that this package writes: whole or not at all, and one clear line when that cannot be done."""

import contextlib
import errno
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import BinaryIO

from warehouse_sim.errors import OutputError

_TEMPORARY = ".part"
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


@contextlib.contextmanager
def writing(path: Path) -> Iterator[None]:
    """Name ``path`` and a remedy when the system rejects what the block writes there.

    Raises:
        OutputError: It did.
    """
    if "\0" in str(path):
        raise OutputError(f"{str(path)!r}: no name may hold a zero byte; choose another place")
    try:
        yield
    except OSError as problem:
        reason = "it is a link that leads nowhere" if os.path.islink(path) and not path.exists() else problem.strerror
        remedy = "free some space or choose another folder" if problem.errno in _FULL else "choose another place"
        raise OutputError(f"{path}: cannot be written ({reason or problem}); {remedy}") from problem


def make_folder(path: Path) -> None:
    """Make a folder, and those that it lies in, unless it is there.

    Raises:
        OutputError: It cannot be made.
    """
    with writing(path):
        path.mkdir(parents=True, exist_ok=True)


def write_bytes(path: Path, data: bytes, durable: bool = False) -> None:
    """Write ``data`` to ``path`` in one step; an existing file is replaced, a device or a pipe is written to.

    Args:
        path: File to make; its folder must exist.
        data: The whole content.
        durable: Force the data to the disk before the rename. Bulk files go without, for speed: a killed process
            loses nothing by that, and what a power cut takes is found by ``warehouse-sim validate``.

    Raises:
        OutputError: The file cannot be written.
    """
    with writing(path):
        if path.exists() and not path.is_file():
            path.write_bytes(data)
            return
        temporary = _temporary(path)
        try:
            with open(temporary, "wb") as file:
                file.write(data)
                if durable:
                    file.flush()
                    os.fsync(file.fileno())
            os.replace(temporary, path)
        except OSError:
            with contextlib.suppress(OSError):
                temporary.unlink()
            raise


@contextlib.contextmanager
def whole_file(path: Path) -> Iterator[BinaryIO]:
    """Open a file to write piece by piece; it is at ``path`` when the block has ended well, and not before.

    Raises:
        OutputError: The file cannot be written.
    """
    temporary = _temporary(path)
    with writing(path):
        try:
            with open(temporary, "wb") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)


def write_pieces(path: Path, pieces: Iterable[bytes]) -> None:
    """Write a file that is made piece by piece, in one step and forced to the disk.

    Args:
        path: File to make; its folder must exist.
        pieces: The content in order; what they raise leaves no file.

    Raises:
        OutputError: The file cannot be written.
    """
    with whole_file(path) as file:
        for piece in pieces:
            file.write(piece)


def hard_link(source: Path, path: Path, data: bytes) -> None:
    """Make ``path`` a second name of ``source``, which holds ``data``; a copy where the disk has no hard links.

    Raises:
        OutputError: The file cannot be written.
    """
    temporary = _temporary(path)
    with writing(path):
        temporary.unlink(missing_ok=True)
    try:
        os.link(source, temporary)
    except OSError:
        write_bytes(path, data)
        return
    with writing(path):
        os.replace(temporary, path)


def link_or_copy(source: Path, path: Path) -> None:
    """Make ``path`` a second name of ``source``; a copy where the disk has no hard links.

    Raises:
        OutputError: The file cannot be written.
    """
    hard_link(source, path, source.read_bytes())


def partial_file(path: Path) -> Path:
    """Return the name under which a file grows that only one process writes, until it is renamed to ``path``."""
    return path.with_name(f".{path.name}{_TEMPORARY}")


def remove_temporaries(root: Path) -> None:
    """Delete what a killed run left behind under ``root``.

    Raises:
        OutputError: It cannot be deleted.
    """
    for path in root.rglob(f".*{_TEMPORARY}"):
        with writing(path):
            path.unlink()


def is_temporary(path: Path) -> bool:
    """Return whether a file is one that was not written to its end, by its name."""
    return path.name.startswith(".") and path.name.endswith(_TEMPORARY)


def _temporary(path: Path) -> Path:
    # The process number keeps two processes apart that write the same shared file.
    return path.with_name(f".{path.name}.{os.getpid()}{_TEMPORARY}")
