"""Turn dataset folders into what training of a detector runs on: images of both splits, classes; then anchors."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detectors.settings import BoxTrainingConfig, DetectorConfig
from warehouse_sim.estimators.images.faces import FACE
from warehouse_sim.estimators.images.rows import SMALL_ARRAYS, load_images
from warehouse_sim.estimators.images.settings import ImageConfig, Reads
from warehouse_sim.estimators.images.streamed import StreamedImages
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.samples.joined import joined_alike
from warehouse_sim.learning.samples.split import reports_reading, require_other_scenes
from warehouse_sim.learning.settings import Progress
from warehouse_sim.learning.trainable import OpenStream


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a training runs on."""

    images: dict[str, list[Arrays]]
    """By split, "train" and "val"; those of one canvas together."""
    class_of: dict[int, int]
    """Class of each object number."""
    classes: tuple[str, ...]
    """Their names."""
    reading: Any
    """What was read of the images."""
    streamed: StreamedImages | None = None
    """What is trained on in place of train, of which that then holds what comes first."""


def prepare(
    readers: Sequence[DatasetReader],
    reads: Reads,
    config: DetectorConfig,
    cache: Path | None,
    progress: Progress | None,
    open_stream: OpenStream | None = None,
) -> Prepared:
    """Read the images of train and val, and find the classes; a stream that is named takes the place of train.

    Args:
        readers: The datasets.
        reads: What the network reads.
        config: Settings.
        cache: Folder to keep images in; None keeps them in memory.
        progress: Called with what is read.
        open_stream: Opens the stream that ``config`` names.

    Raises:
        DatasetError: A folder is no dataset that can be read, or lacks what is read.
        TrainingError: A split is empty, a class is not there, or the stream would show scenes of the data.
    """
    images = ImageConfig(reads, config.input_wh, config.depth_source, FACE in config.classes)
    found: dict[str, list[Arrays]] = {}
    streamed = _streamed(readers, images, config, open_stream) if config.stream.recipe else None
    for split in ("train", "val") if streamed is None else ("val",):
        parts = [
            arrays
            for reader in readers
            for arrays in load_images(
                reader, split, images, config.workers, cache, reports_reading(progress, split, reader)
            )
        ]
        # Samples of a step are of one canvas, and shall be of any dataset.
        found[split] = joined_alike(parts, SMALL_ARRAYS)
    seen = found["val"] if streamed else []
    found["train"] = streamed.first() if streamed else found["train"]
    classes, class_of = known_classes(readers, [*found["train"], *seen], config)
    if streamed and not wanted_sizes(found["train"], class_of, config).size:
        raise TrainingError(
            f"none of the stream's observations, in a window, shows {', '.join(classes)} well enough to train on; "
            "take the recipe that the data was made from, or a larger stream.window"
        )
    require_wanted(found, readers, classes, class_of, config, "--wanted.visible and --wanted.height-px")
    return Prepared(found, class_of, classes, images, streamed)


def _streamed(
    readers: Sequence[DatasetReader], images: ImageConfig, config: DetectorConfig, open_stream: OpenStream | None
) -> StreamedImages:
    """Open the stream that the settings name.

    Raises:
        TrainingError: It would show scenes of the data, or nothing opens it.
    """
    require_other_scenes(readers, config.stream)
    objects = {number: info for reader in readers for number, info in reader.objects.items()}
    return StreamedImages(open_stream, config.stream, images, objects, config.batch, config.seed)


def require_wanted(
    found: dict[str, list[Arrays]],
    readers: Sequence[DatasetReader],
    classes: tuple[str, ...],
    class_of: dict[int, int],
    config: BoxTrainingConfig,
    options: str,
) -> None:
    """Check that each split shows something that is to be found.

    Raises:
        TrainingError: One does not; it names the ``options`` that require less.
    """
    for split, parts in found.items():
        if not wanted_sizes(parts, class_of, config).size:
            folders = ", ".join(str(reader.root) for reader in readers)
            raise TrainingError(
                f"{folders}: the split {split!r} shows none of {', '.join(classes)} well enough; "
                f"generate more scenes, or use fewer with {options}"
            )


def known_classes(
    readers: Sequence[DatasetReader], images: Sequence[Arrays], config: BoxTrainingConfig
) -> tuple[tuple[str, ...], dict[int, int]]:
    """Return the names of the classes that training sees, sorted, and the class of each object number.

    Raises:
        TrainingError: One number stands for two classes, or a class that is requested is not there.
    """
    names: dict[int, str] = {}
    for reader in readers:
        for obj_id, info in reader.objects.items():
            name = info.class_name if config.labels == "class" else info.name
            if names.setdefault(obj_id, name) != name:
                raise TrainingError(f"object {obj_id} is {names[obj_id]} in one dataset and {name} in {reader.root}")
            names[-obj_id] = FACE
    seen = {int(number) for arrays in images for number in np.unique(arrays["labels"][..., 4]) if np.isfinite(number)}
    labels = {names[number] for number in seen}
    if unknown := sorted(set(config.classes) - labels):
        raise TrainingError(f"no target is of the class {unknown[0]!r}; classes: {', '.join(sorted(labels))}")
    classes = tuple(sorted(labels & set(config.classes) if config.classes else labels))
    return classes, {number: classes.index(name) for number, name in names.items() if name in classes}


def wanted_sizes(parts: Sequence[Arrays], class_of: dict[int, int], config: BoxTrainingConfig) -> np.ndarray:
    """Return width and height on the canvas (px) of all boxes that are to be found."""
    labels = [np.asarray(arrays["labels"]).reshape(-1, arrays["labels"].shape[-1]) for arrays in parts]
    rows = np.concatenate(labels) if labels else np.zeros((0, 8), dtype=np.float32)
    rows = rows[np.isfinite(rows[:, 0])]
    rows = rows[np.isin(rows[:, 4].astype(int), list(class_of))]
    rows = rows[config.is_wanted(rows)]
    return rows[:, 2:4] - rows[:, :2]
