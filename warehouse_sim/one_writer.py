"""One process at a time writes a folder: it holds a lock there, which the system frees however the process ends."""

import errno
import logging
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from warehouse_sim.errors import OutputError
from warehouse_sim.output import make_folder, writing

try:
    import fcntl
except ImportError:  # a system without POSIX locks
    fcntl = None  # type: ignore[assignment]

LOCK = ".writing.lock"
"""The file in the folder; it is gone when the writer has ended well, and means nothing unless a process holds it."""
_LONGEST = 200
_HELD = (errno.EWOULDBLOCK, errno.EACCES, errno.EAGAIN)

_log = logging.getLogger(__name__)


@contextmanager
def one_writer(folder: Path) -> Iterator[None]:
    """Be the only process that writes ``folder`` while the block runs; it is made, and removed if it stays empty.

    Processes that this one starts may write there, too; they are its own to coordinate. Where the system or the file
    system knows no locks, a warning says so, and the block runs all the same.

    Args:
        folder: What is written.

    Raises:
        OutputError: Another process writes there, or the folder cannot be made.
    """
    is_new = not os.path.exists(folder)  # which takes a name that is too long for one that is not there
    make_folder(folder)
    path = folder / LOCK
    number = _lock(path)
    try:
        yield
    finally:
        with suppress(OSError):
            path.unlink()  # While it is held: who opened it before sees that it is no longer the file of that name.
        os.close(number)
        if is_new:
            with suppress(OSError):  # It is not empty.
                folder.rmdir()


def is_lock(path: Path) -> bool:
    """Return whether a file of a folder only says that it is being written."""
    return path.name == LOCK


def _lock(path: Path) -> int:
    """Return the open, locked file."""
    while True:
        with writing(path):
            # Open for writing: network file systems lock nothing else.
            number = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            _hold(number, path)
            if _is_named(number, path):
                os.truncate(number, 0)
                os.pwrite(number, f"process {os.getpid()} on {socket.gethostname()}".encode(), 0)
                return number
        except BaseException:
            os.close(number)
            raise
        os.close(number)


def _hold(number: int, path: Path) -> None:
    """Lock an open file.

    Raises:
        OutputError: Another process holds it.
    """
    problem = "this system has no locks of files"
    if fcntl is not None:
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except OSError as rejected:
            if rejected.errno in _HELD:
                raise OutputError(
                    f"{path.parent}: {_holder(number)} is writing there; let it end, or choose another folder"
                ) from rejected
            problem = f"its file system has no locks ({rejected.strerror})"
    _log.warning("%s: %s; see to it that no other process writes there", path.parent, problem)


def _holder(number: int) -> str:
    text = os.pread(number, _LONGEST, 0).decode("utf-8", "replace")
    return text if text.isprintable() and text else "another process"


def _is_named(number: int, path: Path) -> bool:
    """Return whether an open file is still the one of that name: its last holder may have removed it."""
    try:
        return os.path.samestat(os.fstat(number), os.stat(path))
    except FileNotFoundError:
        return False
