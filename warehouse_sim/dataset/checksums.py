"""SHA256SUMS: the checksum of each file of a folder, in the form that ``sha256sum --check`` reads."""

import hashlib
from collections.abc import Iterable
from pathlib import Path

from warehouse_sim.errors import DatasetError
from warehouse_sim.output import write_bytes

CHECKSUMS = "SHA256SUMS"


def write_checksums(folder: Path, names: Iterable[str]) -> None:
    """Store the checksums of the files ``names`` in ``folder``."""
    lines = [f"{hashlib.sha256((folder / name).read_bytes()).hexdigest()}  {name}\n" for name in names]
    write_bytes(folder / CHECKSUMS, "".join(lines).encode("ascii"), durable=True)


def require_checksum(path: Path) -> None:
    """Refuse a file that is not the one whose checksum lies beside it; a folder without checksums says nothing.

    Raises:
        DatasetError: The file was changed, is not listed, or cannot be read.
    """
    sums = path.parent / CHECKSUMS
    if not sums.exists():
        return
    try:
        rows = [line.split("  ") for line in sums.read_text(encoding="ascii").splitlines()]
        found = hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as problem:
        raise DatasetError(f"{problem.filename}: cannot be read ({problem.strerror})") from problem
    except UnicodeDecodeError as problem:
        raise DatasetError(f"{sums}: holds something else than ASCII text ({problem.reason})") from problem
    if [found, path.name] not in rows:
        raise DatasetError(f"{path}: is not the file that {CHECKSUMS} lists; copy or generate the dataset again")
