"""Read all images of a split onto their canvas, once: the arrays stay in a cache and are mapped, not read."""

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.images.rows import image_rows
from warehouse_sim.estimators.images.settings import ImageConfig
from warehouse_sim.learning.array_store import Arrays, joined, kept_arrays

_FORMAT = 1
"""To be raised when the arrays change."""


def load_images(
    reader: DatasetReader,
    split: str,
    config: ImageConfig,
    workers: int,
    cache: Path | None,
    progress: Callable[[float], None] | None = None,
) -> list[Arrays]:
    """Return the arrays of ``image_rows`` for all images of a split, those of one canvas together.

    Args:
        reader: The dataset.
        split: Which split.
        config: What is read.
        workers: Threads that decode images.
        cache: Folder to keep images in; None keeps them in memory.
        progress: Called with the fraction of the images that is read; not called when they are found.

    Raises:
        TrainingError: No such split, or the cache cannot be written.
        DatasetError: Depth is requested, and there is none.
    """
    if split not in reader.splits:
        raise TrainingError(f"{reader.root}: has no split {split!r}; it has: {', '.join(reader.splits) or '(none)'}")
    groups: dict[tuple[int, int], list[ImageRecord]] = {}
    for image in reader.images(split):
        groups.setdefault((image.camera.width, image.camera.height), []).append(image)
    found = list[Arrays | None]()
    for size_wh, images in groups.items():
        chunks = read_rows(partial(image_rows, reader, config=config), images, workers, progress)
        digest = rows_digest(reader, split, [_FORMAT, split, size_wh, asdict(config)])
        found.append(joined(chunks) if cache is None else kept_arrays(cache / f"{split}-{digest}", "images", chunks))
    return [arrays for arrays in found if arrays is not None]


def read_rows(
    read: Callable[[ImageRecord], Arrays],
    images: Sequence[ImageRecord],
    workers: int,
    progress: Callable[[float], None] | None,
) -> Iterator[Arrays]:
    """Yield what is read of each image, in their order, by several threads."""
    with ThreadPoolExecutor(workers) as pool:
        for done, rows in enumerate(pool.map(read, images), start=1):
            yield rows
            if progress:
                progress(done / len(images))


def rows_digest(reader: DatasetReader, split: str, settings: list[Any]) -> str:
    """Return a text that changes with anything the arrays depend on: manifest, labels, sizes of files, settings."""
    digest = hashlib.sha256(json.dumps([reader.digest, *settings]).encode())
    for path in reader.files(split):
        labels = path.read_bytes() if path.suffix in (".json", ".txt") else b""
        digest.update(json.dumps([str(path.relative_to(reader.root)), path.stat().st_size]).encode() + labels)
    return digest.hexdigest()[:24]
