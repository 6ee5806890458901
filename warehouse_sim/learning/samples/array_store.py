"""Arrays of samples on disk, which grow row by row, are made once and never fill the memory."""

import contextlib
import errno
import json
import logging
import os
import shutil
import tempfile
import time
import warnings
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from warehouse_sim.errors import TrainingError
from warehouse_sim.output import write_bytes


class GrowingArray:
    """An .npy file to which rows are appended; its length is written at the end.

    Args:
        path: File to make.
        row_shape: Shape of one row.
        dtype: Type of the numbers.
    """

    def __init__(self, path: Path, row_shape: tuple[int, ...], dtype: np.dtype) -> None:
        self._row_shape, self._dtype, self._count = row_shape, dtype, 0
        self._file = path.open("wb")
        self._header = self._write_header()

    def append(self, rows: np.ndarray) -> None:
        """Write more rows.

        Raises:
            ValueError: They have another shape or type than the first.
        """
        if rows.shape[1:] != self._row_shape or rows.dtype != self._dtype:
            raise ValueError(f"rows of {self._row_shape} {self._dtype} expected, found {rows.shape[1:]} {rows.dtype}")
        self._file.write(np.ascontiguousarray(rows).data)
        self._count += len(rows)

    def close(self) -> None:
        """Write the number of rows and force the file to the disk."""
        self._file.seek(0)
        # numpy leaves room for the first axis to grow, so that the header keeps its length.
        assert self._write_header() == self._header
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()

    def _write_header(self) -> int:
        header = {
            "descr": np.lib.format.dtype_to_descr(self._dtype),
            "fortran_order": False,
            "shape": (self._count, *self._row_shape),
        }
        np.lib.format.write_array_header_1_0(self._file, header)
        return self._file.tell()


def map_array(path: Path) -> np.ndarray:
    """Return the array of an .npy file without reading it; its pages come from the disk when they are touched.

    Raises:
        OSError: The file cannot be read.
        ValueError: It is no array, or shorter than it says.
    """
    return np.load(path, mmap_mode="r", allow_pickle=False)


def shared_tensor(array: np.ndarray) -> Tensor:
    """Return a tensor in the memory of ``array``, which must only be read."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*not writable.*")
        return torch.from_numpy(array)


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
