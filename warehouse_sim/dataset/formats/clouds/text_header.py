"""What the readers of both cloud formats share: a bounded header of text before the points, and their fields."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.files.extent import read_bytes
from warehouse_sim.dataset.files.point_table import Table
from warehouse_sim.errors import DatasetError, shown

LONGEST_HEADER = 65_536
"""Bytes of a header that are looked at."""
MOST_FIELDS = 100
LARGEST_FILE = 2**32
"""Bytes of a file that are read: a sweep of 64 beams has 4 MB."""
FARTHEST = 1e7
"""Largest coordinate that is believed (m)."""


def split_header(path: Path, last_line: bytes) -> tuple[list[list[str]], bytes]:
    """Return the words of each line of a file's header, and what comes after it.

    Args:
        path: The file.
        last_line: How the header's last line begins.

    Raises:
        DatasetError: The file cannot be read, is far too large, or has no such header.
    """
    if path.is_file() and path.stat().st_size > LARGEST_FILE:
        raise DatasetError(f"{path}: is larger than {LARGEST_FILE >> 30} GiB, which no single cloud needs")
    content = read_bytes(path)
    head = content[:LONGEST_HEADER]
    start = 0 if head.startswith(last_line) else head.find(b"\n" + last_line) + 1
    end = head.find(b"\n", start)
    if (start == 0 and not head.startswith(last_line)) or end < 0:
        raise DatasetError(f"{path}: has no line {last_line.decode()!r} in its first {LONGEST_HEADER} bytes")
    try:
        lines = head[:end].decode("ascii").splitlines()
    except UnicodeDecodeError as problem:
        raise DatasetError(f"{path}: the header is no ASCII text ({problem.reason})") from problem
    return [line.split() for line in lines if line.strip()], content[end + 1 :]


def whole_number(word: str, path: Path, what: str) -> int:
    """Return a count of a header.

    Raises:
        DatasetError: It is no whole number of at most ten digits.
    """
    if not (word.isascii() and word.isdigit() and len(word) <= 10):
        raise DatasetError(f"{path}: {what} must be a whole number, found {shown(word)}")
    return int(word)


def table_type(names: Sequence[str], types: Sequence[str], path: Path) -> np.dtype:
    """Return the type of a row.

    Raises:
        DatasetError: Too many fields, a name twice, or no coordinates.
    """
    if len(names) > MOST_FIELDS or len(set(names)) != len(names) or not {"x", "y", "z"} <= set(names):
        raise DatasetError(
            f"{path}: fields must be x, y, z and others, each once and at most {MOST_FIELDS}, "
            f"found {shown(list(names))}"
        )
    return np.dtype(list(zip(names, types, strict=True)))


def rows_of_bytes(body: bytes, count: int, row: np.dtype, path: Path) -> Table:
    """Return ``count`` rows that stand one after the other in ``body``.

    Raises:
        DatasetError: There are fewer bytes, or more.
    """
    if len(body) != count * row.itemsize:
        raise DatasetError(
            f"{path}: {count} points of {row.itemsize} bytes need {count * row.itemsize} bytes, found {len(body)}; "
            "the file was cut or its header changed"
        )
    return np.frombuffer(body, row)


def rows_of_text(body: bytes, count: int, row: np.dtype, path: Path) -> Table:
    """Return ``count`` rows that stand line by line in ``body``.

    Raises:
        DatasetError: There are other lines, or something else than numbers.
    """
    lines = body.split(b"\n")
    while lines and not lines[-1].strip():
        lines.pop()
    names = row.names or ()
    if len(lines) != count:
        raise DatasetError(f"{path}: the header says {count} points, found {len(lines)} lines")
    try:
        values = np.array([line.split() for line in lines], dtype=np.float64).reshape(count, len(names))
    except ValueError as problem:
        raise DatasetError(f"{path}: each point must have {len(names)} numbers ({problem})") from problem
    table = np.empty(count, row)
    for name, column in zip(names, values.T, strict=True):
        kind = row[name]
        limits = np.iinfo(kind) if kind.kind in "iu" else None
        if limits is not None and count and not (column.min() >= limits.min and column.max() <= limits.max):
            raise DatasetError(f"{path}: {name} has a value that does not fit into {kind.itemsize} bytes")
        table[name] = column
    return table


def require_places(table: Table, path: Path) -> Table:
    """Return the table whose points are all somewhere; points that are not a number, "no return", may be there.

    Raises:
        DatasetError: A coordinate is infinite or farther than any.
    """
    for name in ("x", "y", "z"):
        if (np.abs(table[name]) > FARTHEST).any():
            raise DatasetError(f"{path}: {name} has a value beyond {FARTHEST:g} m; is the file damaged?")
    return table
