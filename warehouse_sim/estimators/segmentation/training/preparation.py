"""Turn dataset folders into what training of a segmenter runs on: crops about the boxes of all targets."""

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.images.settings import Reads
from warehouse_sim.estimators.segmentation.face_points import POINTS, pocket_faces, side_points
from warehouse_sim.estimators.segmentation.networks.segmenter import SegmenterNetworkConfig
from warehouse_sim.estimators.segmentation.rows import target_rows
from warehouse_sim.estimators.segmentation.run_config import KnownFaces, RunConfig
from warehouse_sim.estimators.segmentation.settings import BoxCropConfig, SegmenterConfig
from warehouse_sim.estimators.segmentation.training.task import BoxRows
from warehouse_sim.learning.array_store import Arrays, joined, kept_arrays
from warehouse_sim.learning.progress import Progress
from warehouse_sim.learning.run_folder import DatasetSource, package_version

_FORMAT = 1
"""To be raised when the arrays change."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a training runs on."""

    rows: dict[str, BoxRows]
    """By split, "train" and "val"."""
    config: RunConfig
    """The resolved configuration."""


def prepare(
    name: str,
    reads: Reads,
    keypoints: bool,
    data: Sequence[Path],
    config: SegmenterConfig,
    cache: Path | None,
    progress: Progress | None,
) -> Prepared:
    """Cut the boxes of all targets of train and val out of the images.

    Raises:
        DatasetError: A folder is no dataset that can be read, or lacks what is read.
        TrainingError: A split shows too little.
    """
    if not data:
        raise TrainingError("there is nothing to train on: name at least one dataset folder")
    readers = [DatasetReader(folder) for folder in data]
    crop = BoxCropConfig(reads, config.crop_wh)
    rows = dict[str, BoxRows]()
    for split in ("train", "val"):
        parts, chosen = list[Arrays](), list[np.ndarray]()
        for reader in readers:
            note = f"{split} of {reader.root.name}"
            arrays = load_boxes(reader, split, crop, config.workers, cache, _reading(progress, note))
            if arrays is not None:
                parts.append(arrays)
                chosen.append(_wanted(arrays["facts"], reader, config))
        rows[split] = BoxRows(parts, chosen)
        if not len(rows[split]):
            folders = ", ".join(map(str, data))
            raise TrainingError(f"{folders}: the split {split!r} shows no target well enough; generate more scenes")
    sources = tuple(DatasetSource(reader.root.resolve().name, reader.digest) for reader in readers)
    objects = {number: info for reader in readers for number, info in reader.objects.items()}
    faces = tuple(_faces(info) for _, info in sorted(objects.items()) if info.pockets) if keypoints else ()
    network = SegmenterNetworkConfig(reads, config.width, POINTS if keypoints else 0)
    return Prepared(rows, RunConfig(name, package_version(), sources, faces, crop, network, config))


def load_boxes(
    reader: DatasetReader,
    split: str,
    crop: BoxCropConfig,
    workers: int,
    cache: Path | None,
    progress: Callable[[float], None] | None = None,
) -> Arrays | None:
    """Return the arrays of ``target_rows`` for all targets of a split, from the cache if they are there.

    Raises:
        TrainingError: No such split, or the cache cannot be written.
    """
    if split not in reader.splits:
        raise TrainingError(f"{reader.root}: has no split {split!r}; it has: {', '.join(reader.splits) or '(none)'}")
    chunks = _read(reader, split, crop, workers, progress)
    if cache is None:
        return joined(chunks)
    digest = hashlib.sha256(json.dumps([reader.digest, _FORMAT, split, asdict(crop)]).encode())
    for path in reader.files(split):
        labels = path.read_bytes() if path.suffix in (".json", ".txt") else b""
        digest.update(json.dumps([str(path.relative_to(reader.root)), path.stat().st_size]).encode() + labels)
    return kept_arrays(cache / f"boxes-{split}-{digest.hexdigest()[:24]}", "boxes", chunks)


def _read(
    reader: DatasetReader, split: str, crop: BoxCropConfig, workers: int, progress: Callable[[float], None] | None
) -> Iterator[Arrays]:
    images = reader.images(split)
    with ThreadPoolExecutor(workers) as pool:
        for done, rows in enumerate(pool.map(lambda image: target_rows(reader, image, crop), images), start=1):
            if rows is not None:
                yield rows
            if progress:
                progress(done / len(images))


def _wanted(facts: np.ndarray, reader: DatasetReader, config: SegmenterConfig) -> np.ndarray:
    """Return the rows that are trained on."""
    requested = (facts[:, 1] >= config.visible) & (facts[:, 2] >= config.height_px)
    if config.classes:
        known = [i for i, info in reader.objects.items() if {info.class_name, info.name} & set(config.classes)]
        requested &= np.isin(facts[:, 0].astype(int), known)
    return np.flatnonzero(requested)


def _faces(info: ObjectInfo) -> KnownFaces:
    sides = [side_points(info.size, info.pockets, face) for face in pocket_faces(info.pockets)]
    return KnownFaces(
        info.obj_id,
        info.name,
        info.class_name,
        tuple(tuple(float(value) for value in points.ravel()) for points, _ in sides),
        tuple(tuple(bool(value) for value in known) for _, known in sides),
    )


def _reading(progress: Progress | None, what: str) -> Callable[[float], None] | None:
    return (lambda fraction: progress(0.0, f"reading {what} {fraction:.0%}")) if progress else None
