"""What commands check before they work: how many processes, and that no file of an earlier run is lost."""

import os
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from warehouse_sim.errors import InputError, OutputError


def processes(workers: int | None) -> int:
    """Return the number given by ``--workers``, or that of the processors where there is none.

    Raises:
        InputError: It is below 1.
    """
    if workers is not None and workers < 1:
        raise InputError(f"--workers must be at least 1, found {workers}; leave it out for one per processor")
    return workers or os.cpu_count() or 1


def require_free(path: Path, overwrite: bool) -> None:
    """Reject before the work a file that cannot be written after it: one that is there, or a folder.

    Raises:
        OutputError: It is there, and nobody said that it may go.
    """
    if path.is_dir():
        raise OutputError(f"{path}: cannot be written (it is a folder); choose another place")
    if path.is_file() and not overwrite:
        raise OutputError(f"{path}: is there already; name another file, or add --overwrite")
    above = next(folder for folder in path.absolute().parents if folder.exists())
    if not above.is_dir() or not os.access(above, os.W_OK | os.X_OK):
        raise OutputError(f"{path}: cannot be written (nothing can be written below {above}); choose another place")


def write_one(path: Path, write: Callable[[Path], Path], overwrite: bool) -> Path:
    """Let ``write`` make one file and return its path; a file that is there already must stay what it is.

    Args:
        path: File to write.
        write: Takes the path and returns it; the same bytes whatever the folder.
        overwrite: Replace what is there.

    Raises:
        OutputError: The file is there and would get other content.
    """
    if not overwrite and path.is_file():
        with TemporaryDirectory() as place:
            _require_same(path, write(Path(place) / path.name).read_bytes())
    return write(path)


def write_beside(folder: Path, write: Callable[[Path], Path], overwrite: bool) -> Path:
    """Let ``write`` fill a folder and return what it returns; files that are there already must stay what they are.

    Args:
        folder: Where to write.
        write: Takes the folder and returns the file that it wrote last; the same bytes whatever the folder.
        overwrite: Replace what is there.

    Raises:
        OutputError: A file that is there would get other content.
    """
    if not overwrite and folder.is_dir() and any(folder.iterdir()):
        with TemporaryDirectory() as place:
            write(Path(place))
            for made in sorted(path for path in Path(place).rglob("*") if path.is_file()):
                _require_same(folder / made.relative_to(place), made.read_bytes())
    return write(folder)


def _require_same(path: Path, data: bytes) -> None:
    if not path.is_file() or (path.stat().st_size == len(data) and path.read_bytes() == data):
        return
    raise OutputError(f"{path}: is there with other content; name another --out, or add --overwrite")
