"""How much of the disk a dataset may take while it is made."""

import os
from contextlib import suppress
from pathlib import Path

from warehouse_sim.errors import OutputError

_GB = 1e9


class Allowance:
    """Counts scenes, and measures the folder when so many are made that the limit could be near.

    Args:
        root: Folder of the dataset.
        limit_gb: What it may take (GB); None = as much as it does.
        made: Scenes that are there already.
        workers: How many scenes are made at once, each of which is on the disk in part.
    """

    def __init__(self, root: Path, limit_gb: float | None, made: int, workers: int) -> None:
        self._root, self._limit_gb, self._made, self._workers = root, limit_gb, made, workers
        self._safe, self._base = 0, 0 if made else self._used()

    def require_room(self, finished: int, total: int) -> None:
        """Reject to go on where the next scenes would not fit; before the first scene, and after each.

        Args:
            finished: Scenes that are there.
            total: Scenes of the dataset.

        Raises:
            OutputError: They would not.
        """
        if self._limit_gb is None or finished >= total:
            return
        self._safe -= finished - self._made
        self._made = finished
        if self._safe > 0:
            return
        used = self._used()
        each = (used - self._base) / finished if finished else 0.0
        room = self._limit_gb * _GB - used
        if room < self._workers * each or room < 0:
            raise OutputError(
                f"{self._root}: holds {used / _GB:.3f} GB with {finished} of {total} scenes, the next would exceed "
                f"--max-gb {self._limit_gb:g}; go on with --resume and a larger --max-gb"
            )
        # Half of what fits by the mean: scenes differ.
        self._safe = int(room / each / 2) - self._workers if each else 1

    def _used(self) -> int:
        return _bytes_of(self._root) if self._limit_gb is not None else 0


def _bytes_of(root: Path) -> int:
    """Return what the files of a folder take, each once; files that workers rename meanwhile may be missed."""
    found: dict[tuple[int, int], int] = {}
    for folder, _, names in os.walk(root):
        for name in names:
            with suppress(FileNotFoundError):
                status = os.stat(os.path.join(folder, name), follow_symlinks=False)
                found[status.st_dev, status.st_ino] = status.st_size
    return sum(found.values())
