"""What the trainings of all detectors share: images, classes, order; a network brings its sizes and loss."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import torch

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.detectors.boxes import BoxRun
from warehouse_sim.estimators.detectors.preparation import Prepared, prepare
from warehouse_sim.estimators.detectors.settings import AnyDetectorConfig, BoxTrainingConfig, TrainableOnImages
from warehouse_sim.estimators.detectors.task import BoxTask
from warehouse_sim.learning.job import Started, TrainingJob
from warehouse_sim.learning.samples.order import GroupedOrder
from warehouse_sim.learning.settings import Progress


@dataclass(frozen=True)
class BoxJob(TrainingJob):
    """A training of any network that gives boxes."""

    config: BoxTrainingConfig

    run_config: ClassVar[type[BoxRun]]
    task: ClassVar[type[BoxTask]]
    """Its step and validation."""
    samples: ClassVar[str] = "images"
    watched: ClassVar[tuple[str, str]] = ("val_ap50", "validation AP50 {:.1f} %")

    @abstractmethod
    def sizes(self, prepared: Prepared) -> Any:
        """Return the configuration of the network."""

    def prepared(self, readers: Sequence[DatasetReader], progress: Progress | None = None) -> Prepared:
        """Read the samples."""
        assert isinstance(self.config, AnyDetectorConfig)
        assert isinstance(self.method, TrainableOnImages)
        return prepare(readers, self.method.reads, self.config, self.cache_dir, progress)

    def start(self, progress: Progress | None = None) -> Started:
        """Read the samples and make a fresh network."""
        readers = self.readers()
        prepared = self.prepared(readers, progress)
        torch.manual_seed(self.config.seed)
        counts = {split: [len(arrays["labels"]) for arrays in parts] for split, parts in prepared.images.items()}
        order = GroupedOrder(counts["train"], self.config.batch, self.config.seed)
        sizes, read = self.sizes(prepared), {"classes": prepared.classes, "images": prepared.reading}
        config = self.run_config(**self.origin(readers), **read, network=sizes)
        task = self.task(config.make_network(), self.config, prepared.images, prepared.class_of, order)
        return Started(task, order, config, {split: sum(sizes) for split, sizes in counts.items()})
