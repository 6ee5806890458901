"""SHA256SUMS: the checksum of each file of a folder, in the form that ``sha256sum --check`` reads.

That of a whole dataset is named, by its own checksum, in the manifest, which thereby says of every byte what it is.
"""

import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path

from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.errors import DatasetError
from warehouse_sim.one_writer import is_lock
from warehouse_sim.output import is_temporary, write_bytes

CHECKSUMS = "SHA256SUMS"


def write_checksums(folder: Path, names: Iterable[str]) -> None:
    """Store the checksums of the files ``names`` in ``folder``."""
    lines = [f"{file_sum(folder / name)}  {name}\n" for name in names]
    write_bytes(folder / CHECKSUMS, "".join(lines).encode("utf-8"), durable=True)


def file_sum(path: Path) -> str:
    """Return the checksum of a file, in hexadecimal digits.

    Raises:
        DatasetError: It cannot be read.
    """
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as problem:
        raise DatasetError(f"{path}: cannot be read ({problem.strerror})") from problem


def seal(root: Path) -> str:
    """Store the checksums of all files of a dataset but manifest and card, and return that of the list."""
    write_checksums(root, sealed_files(root))
    return file_sum(root / CHECKSUMS)


def sealed_files(root: Path) -> list[str]:
    """Return the names of the files of a dataset that its checksums list, in order.

    The card is not among them: it says how much of this disk the folder takes, with or without hard links.
    """
    own = DatasetLayout(root)
    apart = {own.manifest, own.readme, own.unfinished, own.shard, root / CHECKSUMS}
    found = (path for path in root.rglob("*") if path not in apart and not is_lock(path) and not is_temporary(path))
    return sorted(path.relative_to(root).as_posix() for path in found if path.is_file())


def read_checksums(folder: Path) -> dict[str, str] | None:
    """Return the checksums of a folder's files by their names; None where it has no list.

    Raises:
        DatasetError: The list cannot be read.
    """
    path = folder / CHECKSUMS
    if not path.exists():
        return None
    try:
        rows = (line.partition("  ") for line in path.read_text(encoding="utf-8").split("\n") if line)
        return {name: found for found, _, name in rows}
    except OSError as problem:
        raise DatasetError(f"{path}: cannot be read ({problem.strerror})") from problem
    except UnicodeDecodeError as problem:
        raise DatasetError(f"{path}: holds something else than text ({problem.reason})") from problem


def broken_seals(root: Path, list_sum: str) -> Iterator[str]:
    """Yield a line for each file of a dataset that is not the one that was sealed.

    Args:
        root: Folder of the dataset.
        list_sum: Checksum of its list, from its manifest.

    Raises:
        DatasetError: The list is not the one that the manifest names, or a file cannot be read.
    """
    path = root / CHECKSUMS
    if not path.is_file() or file_sum(path) != list_sum:
        raise DatasetError(f"{path}: is not the list that manifest.json names; copy or generate the dataset again")
    listed = read_checksums(root) or {}
    there = set(sealed_files(root))
    for name in sorted(there | listed.keys()):
        if name not in there:
            yield f"{root / name}: is missing"
        elif name not in listed:
            yield f"{root / name}: is no file that the dataset was made with"
        elif file_sum(root / name) != listed[name]:
            yield f"{root / name}: was changed since the dataset was made"


def require_checksum(path: Path) -> None:
    """Reject a file that is not the one whose checksum lies beside it; a folder without checksums says nothing.

    Raises:
        DatasetError: The file was changed, is not listed, or cannot be read.
    """
    listed = read_checksums(path.parent)
    if listed is not None and file_sum(path) != listed.get(path.name):
        raise DatasetError(f"{path}: is not the file that {CHECKSUMS} lists; copy or generate the dataset again")
