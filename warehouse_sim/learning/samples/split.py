"""The samples of a split of a dataset, read once by several threads and kept on disk."""

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.samples.array_store import Arrays, joined, kept_arrays
from warehouse_sim.learning.settings import Progress, StreamConfig
from warehouse_sim.processes import keep_freed_memory

ReadRows = Callable[[ImageRecord], Arrays | None]
"""Gives some rows of each array for an image; None where it shows nothing."""


def split_images(reader: DatasetReader, split: str) -> Sequence[ImageRecord]:
    """Return the images of a split.

    Raises:
        TrainingError: The dataset has no such split.
    """
    if split not in reader.splits:
        raise TrainingError(f"{reader.root}: has no split {split!r}; it has: {', '.join(reader.splits) or '(none)'}")
    return reader.images(split)


def require_other_scenes(readers: Sequence[DatasetReader], stream: StreamConfig) -> None:
    """Reject a stream with the seed of a dataset.

    Raises:
        TrainingError: It has one.
    """
    for reader in readers:
        if reader.manifest is not None and reader.manifest.seed == stream.seed:
            raise TrainingError(
                f"stream.seed {stream.seed} is the seed of {reader.root}, whose val split would be trained on; "
                "choose another one"
            )


def load_rows(
    reader: DatasetReader,
    split: str,
    images: Sequence[ImageRecord],
    read: ReadRows,
    settings: Sequence[Any],
    what: str,
    workers: int,
    cache: Path | None,
    progress: Callable[[float], None] | None = None,
    name: str = "",
) -> Arrays | None:
    """Return what is read of each image, in their order, end to end; from the cache if it is there.

    Args:
        reader: The dataset.
        split: Which split.
        images: Of the split.
        read: Reads one of them; called in several threads at once.
        settings: What the arrays depend on beside the dataset.
        what: What the rows are, in the plural ("crops").
        workers: Threads.
        cache: Folder to keep the arrays in; None keeps them in memory.
        progress: Called with the fraction of the images that is read; not called when the arrays are found.
        name: What the entry of the cache begins with; the split by default.

    Returns:
        The arrays, or None when there are no rows.

    Raises:
        TrainingError: The cache cannot be written.
    """
    chunks = _read(read, images, workers, progress)
    if cache is None:
        return joined(chunks)
    return kept_arrays(cache / f"{name or split}-{split_digest(reader, split, settings)}", what, chunks)


def split_digest(reader: DatasetReader, split: str, settings: Sequence[Any]) -> str:
    """Return a text that changes with anything that arrays of a split depend on.

    That is the manifest, the settings, the labels, and names and sizes of the images: a dataset that other code
    regenerated may have the same manifest, but not images of the same sizes.
    """
    digest = hashlib.sha256(json.dumps([reader.digest, *settings]).encode())
    for path in reader.files(split):
        labels = path.read_bytes() if path.suffix in (".json", ".txt") else b""
        digest.update(json.dumps([str(path.relative_to(reader.root)), path.stat().st_size]).encode() + labels)
    return digest.hexdigest()[:24]


def reports_reading(progress: Progress | None, split: str, reader: DatasetReader) -> Callable[[float], None] | None:
    """Return what reports how much of a split is read."""
    note = f"reading {split} of {reader.root.name}"
    return (lambda fraction: progress(0.0, f"{note} {fraction:.0%}")) if progress else None


def _read(
    read: ReadRows, images: Sequence[ImageRecord], workers: int, progress: Callable[[float], None] | None
) -> Iterator[Arrays]:
    keep_freed_memory()
    with ThreadPoolExecutor(workers) as pool:
        for done, rows in enumerate(pool.map(read, images), start=1):
            if rows is not None:
                yield rows
            if progress:
                progress(done / len(images))
