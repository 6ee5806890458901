"""Files as bytes and as ASCII text; what cannot be read is an error that names the file."""

from pathlib import Path

from warehouse_sim.errors import DatasetError


def read_text(path: Path) -> str:
    """Read an ASCII file.

    Raises:
        DatasetError: It cannot be read, or holds something else.
    """
    try:
        return read_bytes(path).decode("ascii")
    except UnicodeDecodeError as problem:
        raise DatasetError(f"{path}: holds something else than ASCII text ({problem.reason})") from problem


def read_bytes(path: Path) -> bytes:
    """Read a file.

    Raises:
        DatasetError: It cannot be read.
    """
    try:
        return path.read_bytes()
    except OSError as problem:
        raise DatasetError(f"{path}: cannot be read ({problem.strerror})") from problem
