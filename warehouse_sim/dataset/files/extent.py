"""Where bytes lie that are read as a file: a file of its own, or a part of one, such as a member of an archive."""

from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.errors import DatasetError

ADVICE = "run 'warehouse-sim validate' on the dataset"
"""Ends messages on files that cannot be read."""


@dataclass(frozen=True)
class Extent:
    """A part of a file."""

    path: Path
    name: str
    """Of the part, as errors name it; empty = a file of its own."""
    offset: int
    size: int

    @property
    def where(self) -> str:
        """The part as errors name it."""
        return f"{self.path}/{self.name}" if self.name else str(self.path)

    def read(self, most: int | None = None) -> bytes:
        """Return its bytes, or the first of them.

        Raises:
            DatasetError: The file cannot be read, or became shorter.
        """
        size = self.size if most is None else min(most, self.size)
        data = _read(self.path, self.offset, size)
        if len(data) != size:
            raise DatasetError(f"{self.where}: ends after {len(data)} of {size} bytes; copy the archive again")
        return data


Source = Path | Extent
"""What readers of single files take."""


def read_bytes(source: Source, most: int = -1) -> bytes:
    """Return the bytes of a file or of a part of one, or the first of them.

    Raises:
        DatasetError: It cannot be read.
    """
    if isinstance(source, Extent):
        return source.read(None if most < 0 else most)
    return _read(source, 0, most)


def where_of(source: Source) -> str:
    """Return how errors name it; its ending says what it is."""
    return source.where if isinstance(source, Extent) else str(source)


def _read(path: Path, offset: int, size: int) -> bytes:
    try:
        with open(path, "rb") as file:
            file.seek(offset)
            return file.read(size)
    except OSError as problem:
        raise DatasetError(f"{path}: cannot be read ({problem.strerror}); {ADVICE}") from problem
