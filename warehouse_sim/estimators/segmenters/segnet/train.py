"""The training of a segmenter: datasets become crops about boxes, masks and key points, which are trained on."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import torch

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.segmenters.segnet.keypoints import POINTS, pocket_faces, side_points
from warehouse_sim.estimators.segmenters.segnet.network import KnownFaces, SegmenterNetworkConfig, SegmenterRun
from warehouse_sim.estimators.segmenters.segnet.rows import prepare
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig, SegmenterConfig, TrainableSegmenter
from warehouse_sim.estimators.segmenters.segnet.streamed import StreamedBoxes
from warehouse_sim.estimators.segmenters.segnet.task import Boxes, SegmentationTask
from warehouse_sim.learning.job import Started, TrainingJob
from warehouse_sim.learning.loop import Order
from warehouse_sim.learning.run_folder import RunConfig
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.samples.split import require_other_scenes
from warehouse_sim.learning.settings import Progress


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
