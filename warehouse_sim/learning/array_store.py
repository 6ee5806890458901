"""Keep arrays of samples on disk, so that they are made once and never fill the memory."""

import contextlib
import errno
import json
import logging
import shutil
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.array_file import GrowingArray, map_array
from warehouse_sim.output import write_bytes

_LEFTOVER_SECONDS = 24 * 3600.0

log = logging.getLogger(__name__)

Arrays = dict[str, np.ndarray]
"""Arrays of the same length by name."""


def kept_arrays(entry: Path, what: str, chunks: Iterable[Arrays]) -> Arrays | None:
    """Return the arrays of an entry of a cache; where there is none, it is made of ``chunks`` laid end to end.

    Args:
        entry: Folder of the entry.
        what: What its rows are, in the plural ("crops"); names its table of contents.
        chunks: Requested only if the entry is missing or damaged.

    Returns:
        The arrays, or None when there are no rows.

    Raises:
        TrainingError: The cache cannot be written.
    """
    arrays = _open(entry, what)
    if arrays is not None:
        return arrays
    try:
        return _fill(entry, what, chunks)
    except OSError as problem:
        raise TrainingError(
            f"{entry.parent}: {what} cannot be kept there ({problem.strerror or problem}); free some space, choose "
            "another folder with --cache, or keep them in memory with --cache none"
        ) from problem


def joined(chunks: Iterable[Arrays]) -> Arrays | None:
    """Return arrays laid end to end in memory; None of nothing."""
    parts = list(chunks)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]} if parts else None


def _fill(entry: Path, what: str, chunks: Iterable[Arrays]) -> Arrays | None:
    """Write an entry under another name, then rename it: it is whole or not there. Return its arrays, if any.

    They are opened before the rename: open files stay what they are, whatever others do to the entry afterwards.
    """
    entry.parent.mkdir(parents=True, exist_ok=True)
    _remove_leftovers(entry)
    folder, count = _unique_folder(entry), 0
    try:
        files: dict[str, GrowingArray] = {}
        for arrays in chunks:
            count += len(next(iter(arrays.values())))
            for name, rows in arrays.items():
                if name not in files:
                    files[name] = GrowingArray(folder / f"{name}.npy", rows.shape[1:], rows.dtype)
                files[name].append(rows)
        for file in files.values():
            file.close()
        contents = {what: count, "bytes": {path.name: path.stat().st_size for path in sorted(folder.iterdir())}}
        write_bytes(_contents(folder, what), (json.dumps(contents, indent=1) + "\n").encode(), durable=True)
        found = _open(folder, what) if count else None
        if found is not None:
            _publish(folder, entry, what)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return found


def _publish(folder: Path, entry: Path, what: str) -> None:
    """Give a whole folder the name of the entry, unless another whole one has it: both hold the same.

    A rename never replaces a folder that holds anything. A damaged one is moved aside; should another process have put
    a whole one there since it was looked at, then that is moved, and this one, just as whole, takes its place.
    """
    while True:
        try:
            folder.rename(entry)
            return
        except OSError as problem:
            if problem.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                raise
        if _open(entry, what) is not None:
            return
        aside = _unique_folder(entry)
        with contextlib.suppress(FileNotFoundError):  # Another process moved it first.
            entry.rename(aside)
        shutil.rmtree(aside, ignore_errors=True)


def _unique_folder(entry: Path) -> Path:
    return Path(tempfile.mkdtemp(prefix=f".{entry.name}.", dir=entry.parent))


def _contents(folder: Path, what: str) -> Path:
    return folder / f"{what}.json"


def _open(entry: Path, what: str) -> Arrays | None:
    """Return the arrays of an entry, or None when it is missing or damaged."""
    try:
        contents = json.loads(_contents(entry, what).read_bytes())
        sizes = {name: (entry / name).stat().st_size for name in contents["bytes"]}
        arrays = {name.removesuffix(".npy"): map_array(entry / name) for name in contents["bytes"]}
    except (OSError, ValueError, KeyError, TypeError) as problem:
        if entry.exists():
            log.warning("%s: damaged, the %s are cut again (%s)", entry, what, problem)
        return None
    if sizes != contents["bytes"] or {len(array) for array in arrays.values()} != {contents[what]}:
        log.warning("%s: damaged, the %s are cut again", entry, what)
        return None
    return arrays


def _remove_leftovers(entry: Path) -> None:
    """Delete what killed processes left of this entry; younger folders may be somebody's at work."""
    for folder in entry.parent.glob(f".{entry.name}.*"):
        with contextlib.suppress(OSError):
            if time.time() - folder.stat().st_mtime > _LEFTOVER_SECONDS:
                shutil.rmtree(folder, ignore_errors=True)
