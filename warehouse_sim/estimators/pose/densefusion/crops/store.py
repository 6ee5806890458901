"""Keep the crops of a split on disk, so that they are cut out of the images once and never fill the memory."""

import contextlib
import errno
import hashlib
import json
import logging
import shutil
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.array_file import GrowingArray, map_array
from warehouse_sim.estimators.pose.densefusion.crops.config import CropConfig
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import stack_arrays
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop
from warehouse_sim.estimators.pose.densefusion.crops.read import read_crops
from warehouse_sim.output import write_bytes

_FORMAT = 2
"""To be raised when the arrays change."""
_SEED = 0
"""Decides which pixels of large targets are kept: one choice for all trainings, so that they share their crops."""
_CONTENTS = "crops.json"
_LEFTOVER_SECONDS = 24 * 3600.0

log = logging.getLogger(__name__)

Arrays = dict[str, np.ndarray]


def load_crops(
    reader: DatasetReader,
    split: str,
    config: CropConfig,
    workers: int,
    cache: Path | None,
    progress: Callable[[float], None] | None = None,
) -> Arrays | None:
    """Return the arrays of ``stack_arrays`` for all wanted targets of a split, from the cache if they are there.

    Networks with and without colour or depth share one entry of the cache: each takes the columns it reads.

    Args:
        reader: The dataset.
        split: Which split.
        config: How to cut.
        workers: Threads that decode images.
        cache: Folder to keep crops in; None keeps them in memory.
        progress: Called with the share of the images that is read; not called when the crops are found.

    Returns:
        The arrays, or None when the split has no usable target.

    Raises:
        TrainingError: No such split, or the cache cannot be written.
    """
    if cache is None:
        parts = [stack_arrays(crops, config) for crops in read_crops(reader, split, config, _SEED, workers, progress)]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]} if parts else None
    whole = replace(config, rgb=True, depth=True) if config.side_px else config
    entry = cache / f"{split}-{crops_digest(reader, split, whole)}"
    arrays = _open(entry)
    if arrays is None:
        chunks = read_crops(reader, split, whole, _SEED, workers, progress)
        try:
            arrays = _fill(entry, chunks, whole)
        except OSError as problem:
            raise TrainingError(
                f"{cache}: crops cannot be kept there ({problem.strerror or problem}); free some space, choose another "
                "folder with --cache, or keep them in memory with --cache none"
            ) from problem
    unwanted = set() if config.reads_rgb else {"rgb"}
    unwanted |= set() if config.reads_depth else {"depth", "depth_base", "ray_map"}
    return None if arrays is None else {name: array for name, array in arrays.items() if name not in unwanted}


def crops_digest(reader: DatasetReader, split: str, config: CropConfig) -> str:
    """Return a text that changes with anything the crops depend on.

    That is the manifest, the way of cutting, the labels, and names and sizes of the images: a dataset that other code
    made anew may have the same manifest, but not images of the same sizes.
    """
    digest = hashlib.sha256(json.dumps([reader.digest, _FORMAT, _SEED, split, asdict(config)]).encode())
    for path in reader.files(split):
        labels = path.read_bytes() if path.suffix in (".json", ".txt") else b""
        digest.update(json.dumps([str(path.relative_to(reader.root)), path.stat().st_size]).encode() + labels)
    return digest.hexdigest()[:24]


def _fill(entry: Path, chunks: Iterable[Sequence[Crop]], config: CropConfig) -> Arrays | None:
    """Write an entry under another name, then rename it: it is whole or not there. Return its arrays, if any.

    They are opened before the rename: open files stay what they are, whatever others do to the entry afterwards.
    """
    entry.parent.mkdir(parents=True, exist_ok=True)
    _remove_leftovers(entry)
    folder, count = _unique_folder(entry), 0
    try:
        files: dict[str, GrowingArray] = {}
        for crops in chunks:
            count += len(crops)
            for name, rows in stack_arrays(crops, config).items():
                if name not in files:
                    files[name] = GrowingArray(folder / f"{name}.npy", rows.shape[1:], rows.dtype)
                files[name].append(rows)
        for file in files.values():
            file.close()
        contents = {"crops": count, "bytes": {path.name: path.stat().st_size for path in sorted(folder.iterdir())}}
        write_bytes(folder / _CONTENTS, (json.dumps(contents, indent=1) + "\n").encode(), durable=True)
        arrays = _open(folder) if count else None
        if arrays is not None:
            _publish(folder, entry)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return arrays


def _publish(folder: Path, entry: Path) -> None:
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
        if _open(entry) is not None:
            return
        aside = _unique_folder(entry)
        with contextlib.suppress(FileNotFoundError):  # Another process moved it first.
            entry.rename(aside)
        shutil.rmtree(aside, ignore_errors=True)


def _unique_folder(entry: Path) -> Path:
    return Path(tempfile.mkdtemp(prefix=f".{entry.name}.", dir=entry.parent))


def _open(entry: Path) -> Arrays | None:
    """Return the arrays of an entry, or None when it is missing or damaged."""
    try:
        contents = json.loads((entry / _CONTENTS).read_bytes())
        sizes = {name: (entry / name).stat().st_size for name in contents["bytes"]}
        arrays = {name.removesuffix(".npy"): map_array(entry / name) for name in contents["bytes"]}
    except (OSError, ValueError, KeyError, TypeError) as problem:
        if entry.exists():
            log.warning("%s: damaged, the crops are cut again (%s)", entry, problem)
        return None
    if sizes != contents["bytes"] or {len(array) for array in arrays.values()} != {contents["crops"]}:
        log.warning("%s: damaged, the crops are cut again", entry)
        return None
    return arrays


def _remove_leftovers(entry: Path) -> None:
    """Delete what killed processes left of this entry; younger folders may be somebody's at work."""
    for folder in entry.parent.glob(f".{entry.name}.*"):
        with contextlib.suppress(OSError):
            if time.time() - folder.stat().st_mtime > _LEFTOVER_SECONDS:
                shutil.rmtree(folder, ignore_errors=True)
