"""What the training of a segmenter has of its own."""

from dataclasses import dataclass
from typing import ClassVar

import torch

from warehouse_sim.estimators.segmenters.segnet.keypoints import POINTS
from warehouse_sim.estimators.segmenters.segnet.network import SegmenterNetworkConfig, SegmenterRun
from warehouse_sim.estimators.segmenters.segnet.preparation import known_faces, prepare
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig, SegmenterConfig, TrainableSegmenter
from warehouse_sim.estimators.segmenters.segnet.task import SegmentationTask
from warehouse_sim.learning.job import Started, TrainingJob
from warehouse_sim.learning.run_folder import RunConfig
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.settings import Progress


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
        order = SampleOrder(len(rows["train"]), self.config.batch, self.config.seed)
        task = SegmentationTask(config.make_network(), self.config, crop, rows, order)
        return Started(task, order, config, {split: len(part) for split, part in rows.items()})
