"""The training of a segmenter: datasets become crops about boxes, masks and key points, which are trained on."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import torch
from jaxtyping import Int
from torch import Tensor

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.images.streamed import ObservedAmong
from warehouse_sim.estimators.segmenters.segnet.keypoints import POINTS, pocket_faces, side_points
from warehouse_sim.estimators.segmenters.segnet.network import KnownFaces, SegmenterNetworkConfig, SegmenterRun
from warehouse_sim.estimators.segmenters.segnet.rows import prepare, target_rows, wanted_rows
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig, SegmenterConfig, TrainableSegmenter
from warehouse_sim.estimators.segmenters.segnet.task import Boxes, BoxRows, SegmentationTask
from warehouse_sim.learning.job import Started, TrainingJob
from warehouse_sim.learning.loop import Order
from warehouse_sim.learning.run_folder import RunConfig
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.samples.split import require_other_scenes
from warehouse_sim.learning.samples.stream_window import Arrivals, StreamWindow, seed_since
from warehouse_sim.learning.settings import Progress
from warehouse_sim.learning.trainable import OpenStream
from warehouse_sim.schema import Observation

_MOST_BOXES = 1 << 31
"""More boxes than a window shows: what came at a step is numbered from the step times this."""


class StreamedBoxes:
    """The boxes of a stream's window and the order in which steps draw them; both depend on the step alone.

    Args:
        open_stream: Gives the observations.
        config: Settings, which name the stream.
        crop: How boxes are cut out.
        objects: Objects of the data.

    Raises:
        TrainingError: Nothing opens the stream.
    """

    def __init__(
        self,
        open_stream: OpenStream | None,
        config: SegmenterConfig,
        crop: BoxCropConfig,
        objects: Mapping[int, ObjectInfo],
    ) -> None:
        if open_stream is None:
            raise TrainingError(f"nothing here opens the stream of {config.stream.recipe}: give train() one")
        opened, stream = open_stream, config.stream
        self._config, self._crop, self._objects = config, crop, objects
        window = StreamWindow(lambda start: opened(stream, start), self._rows, stream.window, stream.fresh)
        self._arrivals = Arrivals(window, self._gathered)

    def indices(self, step: int) -> Int[Tensor, " b"]:
        """Return the numbers of one step's boxes."""
        arrived, (_, order) = self._arrivals.at(step)
        return order.indices(step - arrived) + arrived * _MOST_BOXES

    def at(self, index: int) -> tuple[Arrays, int]:
        """Return the arrays that hold a box of this step or the one before, and its row there."""
        arrived, row = divmod(index, _MOST_BOXES)
        return self._arrivals.since(arrived)[0].at(row)

    def _gathered(self, shown: list[Arrays | None], arrived: int) -> tuple[BoxRows, SampleOrder]:
        parts = [part for part in shown if part is not None]
        rows = BoxRows(parts, [wanted_rows(part["facts"], self._objects, self._config) for part in parts])
        if not len(rows):
            raise TrainingError("none of the stream's observations, in a window, shows a target well enough")
        return rows, SampleOrder(len(rows), self._config.batch, seed_since(self._config.seed, arrived))

    def _rows(self, observation: Observation) -> Arrays | None:
        image = ObservedAmong(observation, self._objects)
        return target_rows(image, image.record, self._crop)


def known_faces(readers: Sequence[DatasetReader]) -> tuple[KnownFaces, ...]:
    """Return the objects with pockets of some datasets, by number."""
    objects = {number: info for reader in readers for number, info in reader.objects.items()}
    return tuple(_faces(info) for _, info in sorted(objects.items()) if info.pockets)


def _faces(info: ObjectInfo) -> KnownFaces:
    sides = [side_points(info.size, info.pockets, face) for face in pocket_faces(info.pockets)]
    return KnownFaces(
        info.obj_id,
        info.name,
        info.class_name,
        tuple(tuple(float(value) for value in points.ravel()) for points, _ in sides),
        tuple(tuple(bool(value) for value in known) for _, known in sides),
    )


@dataclass(frozen=True)
class SegmenterJob(TrainingJob):
    """A training of a segmenter."""

    method: TrainableSegmenter
    config: SegmenterConfig

    run_config: ClassVar[type[RunConfig]] = SegmenterRun
    samples: ClassVar[str] = "boxes"
    watched: ClassVar[tuple[str, str]] = ("val_iou", "validation IoU {:.1f} %")

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.width <= 24

    def start(self, progress: Progress | None = None) -> Started:
        """Read the samples and make a fresh network."""
        readers, method = self.readers(), self.method
        crop = BoxCropConfig(method.reads, self.config.crop_wh)
        rows = prepare(readers, crop, self.config, self.cache_dir, progress)
        config = SegmenterRun(
            **self.origin(readers),
            objects=known_faces(readers) if method.keypoints else (),
            crop=crop,
            network=SegmenterNetworkConfig(method.reads, self.config.width, POINTS if method.keypoints else 0),
        )
        torch.manual_seed(self.config.seed)
        counts, stream, remark = {split: len(part) for split, part in rows.items()}, self.config.stream, ""
        train: Boxes
        order: Order
        if stream.recipe:
            require_other_scenes(readers, stream)
            objects = {number: info for reader in readers for number, info in reader.objects.items()}
            order = train = StreamedBoxes(self.open_stream, self.config, crop, objects)
            remark = f"train: the stream of {stream.recipe}, seed {stream.seed}"
        else:
            order, train = SampleOrder(len(rows["train"]), self.config.batch, self.config.seed), rows["train"]
        task = SegmentationTask(config.make_network(), self.config, crop, train, rows["val"], order)
        return Started(task, order, config, counts, remark)
