"""The training of a network that gives boxes: a step, a validation, and the job with anchors for its data."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detectors.boxes import Kept, box_precision, suppress
from warehouse_sim.estimators.detectors.preparation import Prepared, prepare, wanted_sizes
from warehouse_sim.estimators.detectors.settings import BoxTrainingConfig, DetectorConfig, TrainableDetector
from warehouse_sim.estimators.detectors.yolov5.anchors import Targets, cluster_anchors
from warehouse_sim.estimators.detectors.yolov5.losses import detection_loss
from warehouse_sim.estimators.detectors.yolov5.network import (
    DEPTH,
    FEATURES,
    STRIDES,
    WIDTHS,
    BoxRun,
    CellNetwork,
    DetectorNetworkConfig,
    DetectorRun,
)
from warehouse_sim.estimators.images.compose import Sample, composed_sample, plain_sample
from warehouse_sim.learning.job import Started, TrainingJob
from warehouse_sim.learning.loop import ComposedTask
from warehouse_sim.learning.run_folder import read_weights
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.samples.order import GroupedOrder
from warehouse_sim.learning.settings import LoopConfig, Progress
from warehouse_sim.resources import model_dir

_VALIDATION_BATCH = 8
_MOST_VALIDATED = 300
"""Images of a validation, evenly spread."""
_LEAST_SCORE = 0.01
_CALM_FRACTION = 0.15
"""Last fraction of the run without mosaics, so that it ends on images as they are."""
_MAX_OVERLAP = 0.6
"""Of a detection with a better one of its class, in validation."""
_WHERE_FEATURES_ARE = "begin with weights that hold it: --init DIR (docs/detection.md#detectors)"
_ANCHORS_A_LEVEL = 3
_MOST_CLUSTERED = 20_000
"""Boxes that anchors are found from."""
Inputs = tuple[Tensor | None, Tensor | None]


class Groups(Protocol):
    """Arrays of images of one canvas each, by number."""

    def __getitem__(self, group: int, /) -> Arrays:
        """Return those of a group."""


class ImageOrder(Protocol):
    """Which images each step takes; all are of one group."""

    def indices(self, step: int) -> Int[Tensor, " b"]:
        """Return the numbers of one step's images."""

    def group_of(self, index: Int[Tensor, " b"]) -> tuple[int, Int[Tensor, " b"]]:
        """Return the group of a step's images, and their rows in it."""


class _Place(NamedTuple):
    """What decides a sample."""

    step: int
    place: int
    """In the step."""
    group: int
    row: int
    mosaics: bool
    """Whether it may be one."""


class BoxTask(ComposedTask[_Place, Sample]):
    """Train a network that gives boxes on samples composed again at each step, of images where nothing else is said.

    Args:
        network: What is trained.
        config: Settings.
        train: Arrays of images to learn from, by group of one canvas.
        val: Those to validate on.
        class_of: Class of each object number.
        order: Order of the training samples, which says which group they are of.
    """

    network: CellNetwork

    def __init__(
        self,
        network: CellNetwork,
        config: BoxTrainingConfig,
        train: Groups,
        val: Sequence[Arrays],
        class_of: dict[int, int],
        order: ImageOrder,
    ) -> None:
        super().__init__(network, config.workers)
        self.config, self._train, self._val = config, train, val
        self._class_of, self._order = class_of, order

    def forward(self, index: Int[Tensor, " b"], part: slice, step: int, fraction: float) -> Float[Tensor, ""]:
        """Return the loss on the images ``index``, composed afresh."""
        mosaics = fraction < 1.0 - _CALM_FRACTION
        following = self._order.indices(step + 1)
        # Whether the next step has mosaics is known when it comes; it is probably as this one.
        samples = self._samples.take(
            self._keys(index, part, step, mosaics), self._keys(following, part, step + 1, mosaics)
        )
        return self.loss(self._tensors(samples), self._targets(samples))

    def composed(self, arrays: Arrays, row: int, rng: np.random.Generator, mosaics: bool) -> Sample:
        """Return a training sample of a row of arrays, disturbed afresh: zoomed, shifted, mirrored, or a mosaic."""
        assert isinstance(self.config, DetectorConfig)
        return composed_sample(arrays, row, self.config.augment, rng, mosaics)

    def plain(self, arrays: Arrays, row: int) -> Sample:
        """Return a row of arrays as validation sees it."""
        return plain_sample(arrays, row)

    def loss(self, inputs: Inputs, targets: Targets) -> Float[Tensor, ""]:
        """Return CIoU, objectness and classes, weighted, of colours and depths and what is to be found in them."""
        raw = self.network(*inputs)
        with torch.autocast(self._device.type, enabled=False):
            return detection_loss(self.network, raw, targets)

    def _keys(self, index: Int[Tensor, " b"], part: slice, step: int, mosaics: bool) -> list[_Place]:
        group, rows = self._order.group_of(index)
        return [_Place(step, place, group, row, mosaics) for place, row in enumerate(rows.tolist())][part]

    def compose(self, at: _Place) -> Sample:
        """Return the training sample of a place in a step."""
        rng = np.random.default_rng([self.config.seed, at.step, at.place])
        return self.composed(self._train[at.group], at.row, rng, at.mosaics)

    def validate(self, network: nn.Module) -> dict[str, float]:
        """Return average precisions of boxes (%), at overlaps of 0.5 and 0.75."""
        assert isinstance(network, CellNetwork)
        images = [(arrays, row) for arrays in self._val for row in range(len(arrays["labels"]))]
        images = images[:: max(1, -(-len(images) // _MOST_VALIDATED))]
        found, gt = list[Kept](), list[np.ndarray]()
        for start in range(0, len(images), _VALIDATION_BATCH):
            group = [self.plain(arrays, row) for arrays, row in images[start : start + _VALIDATION_BATCH]]
            found += self._detect(network, group)
            gt += [sample.labels for sample in group]
        rows = [self._known(labels) for labels in gt]
        boxes, classes = [labels[:, :4].astype(float) for labels, _ in rows], [numbers for _, numbers in rows]
        requested = [self.config.is_wanted(labels) for labels, _ in rows]
        classes_known = network.config.classes
        return {
            f"val_ap{round(100 * overlap)}": box_precision(found, boxes, classes, requested, classes_known, overlap)
            for overlap in (0.5, 0.75)
        }

    def _detect(self, network: CellNetwork, samples: Sequence[Sample]) -> list[Kept]:
        found = list[Kept]()
        sizes = {_size(sample) for sample in samples}
        # Images of several canvases pass one after the other.
        parts = [samples] if len(sizes) == 1 else [[sample] for sample in samples]
        for part in parts:
            boxes, scores = network.decode(network(*self._tensors(part)))
            for box, score in zip(boxes.cpu().numpy(), scores.cpu().numpy(), strict=True):
                found.append(suppress(box.astype(float), score, _LEAST_SCORE, _MAX_OVERLAP))
        return found

    def _tensors(self, samples: Sequence[Sample]) -> Inputs:
        rgb = [sample.rgb for sample in samples if sample.rgb is not None]
        depth = [sample.depth for sample in samples if sample.depth is not None]
        return self.stacked(rgb) if rgb else None, self.stacked(depth) if depth else None

    def _targets(self, samples: Sequence[Sample]) -> Targets:
        parts = [self._known(sample.labels) for sample in samples]
        labels = np.concatenate([rows for rows, _ in parts])
        classes = np.concatenate([numbers for _, numbers in parts])
        image = np.repeat(np.arange(len(parts)), [len(rows) for rows, _ in parts])
        wanted = self.config.is_wanted(labels)
        return Targets(*map(torch.from_numpy, (image, labels[:, :4].astype(np.float32), classes, wanted)))

    def _known(self, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the labels of classes that are detected, and their classes."""
        numbers = np.array([self._class_of.get(int(obj_id), -1) for obj_id in labels[:, 4]], dtype=np.int64)
        return labels[numbers >= 0], numbers[numbers >= 0]


def _size(sample: Sample) -> tuple[int, ...]:
    image = sample.rgb if sample.rgb is not None else sample.depth
    assert image is not None
    return image.shape


@dataclass(frozen=True)
class BoxJob(TrainingJob):
    """A training of a network that gives boxes, of images where nothing else is said."""

    config: BoxTrainingConfig

    run_config: ClassVar[type[BoxRun]] = DetectorRun
    task: ClassVar[type[BoxTask]] = BoxTask
    """Its step and validation."""
    samples: ClassVar[str] = "images"
    watched: ClassVar[tuple[str, str]] = ("val_ap50", "validation AP50 {:.1f} %")

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.size != "small"

    def sizes(self, prepared: Prepared) -> DetectorNetworkConfig:
        """Return widths by size, and anchors for the boxes of the training data."""
        rng, boxes = np.random.default_rng(self.config.seed), prepared.images["train"]
        sizes = rng.permutation(wanted_sizes(boxes, prepared.class_of, self.config))[:_MOST_CLUSTERED]
        fit = cluster_anchors(sizes, _ANCHORS_A_LEVEL * len(STRIDES), rng)
        anchors = tuple((round(float(w), 2), round(float(h), 2)) for w, h in fit.anchors_wh)
        backbone = self.config.backbone if isinstance(self.config, DetectorConfig) else "csp"
        return DetectorNetworkConfig(WIDTHS[self.config.size], DEPTH, len(prepared.classes), anchors, backbone)

    def settings(self, start: str | Path | None) -> LoopConfig:
        """Return the settings.

        Raises:
            TrainingError: Features that are not trained are requested for what they cannot read, or without weights.
        """
        config = self.config
        if isinstance(config, DetectorConfig) and config.backbone != "csp":
            if not isinstance(self.method, TrainableDetector) or self.method.reads != ("rgb",):
                raise TrainingError(f"backbone {config.backbone} reads colours alone; train detector-rgb with it")
            if start is None:
                raise TrainingError(f"backbone {config.backbone} is not trained; {_WHERE_FEATURES_ARE}")
            if not any(name.startswith(FEATURES) for name in read_weights(model_dir(start))):
                raise TrainingError(f"{start} has no weights of backbone {config.backbone}; {_WHERE_FEATURES_ARE}")
        return super().settings(start)

    def prepared(self, readers: Sequence[DatasetReader], progress: Progress | None = None) -> Prepared:
        """Read the samples."""
        assert isinstance(self.config, DetectorConfig)
        assert isinstance(self.method, TrainableDetector)
        return prepare(readers, self.method.reads, self.config, self.cache_dir, progress, self.open_stream)

    def start(self, progress: Progress | None = None) -> Started:
        """Read the samples and make a fresh network."""
        readers = self.readers()
        prepared = self.prepared(readers, progress)
        torch.manual_seed(self.config.seed)
        counts = {split: [len(arrays["labels"]) for arrays in parts] for split, parts in prepared.images.items()}
        order: ImageOrder
        train: Groups
        remark = ""
        if prepared.streamed is None:
            order, train = GroupedOrder(counts["train"], self.config.batch, self.config.seed), prepared.images["train"]
        else:
            assert isinstance(self.config, DetectorConfig)
            order = train = prepared.streamed
            stream, _ = self.config.stream, counts.pop("train")
            remark = f"train: the stream of {stream.recipe}, seed {stream.seed}"
        sizes, read = self.sizes(prepared), {"classes": prepared.classes, "images": prepared.reading}
        config = self.run_config(**self.origin(readers), **read, network=sizes)
        task = self.task(config.make_network(), self.config, train, prepared.images["val"], prepared.class_of, order)
        return Started(task, order, config, {split: sum(sizes) for split, sizes in counts.items()}, remark)
