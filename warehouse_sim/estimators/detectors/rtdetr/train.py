"""One training of an RT-DETR: its step, its job; samples and validation are those of the package's own detector."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import torch
from jaxtyping import Float
from torch import Tensor

from warehouse_sim.estimators.detectors.boxes import BoxRun
from warehouse_sim.estimators.detectors.job import BoxJob
from warehouse_sim.estimators.detectors.preparation import Prepared
from warehouse_sim.estimators.detectors.rtdetr.estimator import RTDETR_DETECT
from warehouse_sim.estimators.detectors.rtdetr.loss import Labels, make_loss
from warehouse_sim.estimators.detectors.rtdetr.network import SIZES, RtdetrNetwork, RtdetrNetworkConfig, RtdetrRun
from warehouse_sim.estimators.detectors.rtdetr.settings import RtdetrConfig
from warehouse_sim.estimators.detectors.rtdetr.start import start_from
from warehouse_sim.estimators.detectors.task import BoxTask, ImageBoxTask, Inputs
from warehouse_sim.estimators.detectors.yolov5.assignment import Targets
from warehouse_sim.estimators.images.order import GroupedOrder
from warehouse_sim.learning.compute import on_device
from warehouse_sim.learning.job import Started
from warehouse_sim.learning.records import RunLog
from warehouse_sim.learning.run_folder import StartingWeights
from warehouse_sim.learning.samples.array_store import Arrays


class RtdetrTask(ImageBoxTask):
    """Train an RT-DETR; see ``BoxTask`` for the arguments."""

    network: RtdetrNetwork
    most_overlap = RTDETR_DETECT.most_overlap

    def __init__(
        self,
        network: RtdetrNetwork,
        config: RtdetrConfig,
        images: dict[str, list[Arrays]],
        class_of: dict[int, int],
        order: GroupedOrder,
    ) -> None:
        super().__init__(network, config, images, class_of, order)
        self._loss = make_loss(network.model.config, config.loss)

    def loss(self, inputs: Inputs, targets: Targets) -> Float[Tensor, ""]:
        """Return the weighted sum over all layers."""
        rgb, depth = inputs
        image = depth if rgb is None else rgb
        assert image is not None
        labels = [
            {name: on_device(value, image.device) for name, value in of_image.items()}
            for of_image in as_labels(targets, len(image), (image.shape[2], image.shape[1]))
        ]
        found = self.network(rgb, depth, labels)
        with torch.autocast(image.device.type, enabled=False):
            return self._loss(found, labels)


def as_labels(targets: Targets, images: int, size_wh: tuple[int, int]) -> Labels:
    """Return the targets of each image on a canvas of ``size_wh`` (px) as the library wants them."""
    centre, size = (targets.boxes[:, :2] + targets.boxes[:, 2:]) / 2, targets.boxes[:, 2:] - targets.boxes[:, :2]
    boxes = torch.cat([centre, size], dim=1) / targets.boxes.new_tensor(size_wh * 2)
    labels: Labels = []
    for number in range(images):
        mine = targets.image == number
        requested, ignored = mine & targets.wanted, mine & ~targets.wanted
        labels.append({
            "class_labels": targets.class_index[requested], "boxes": boxes[requested], "ignored": boxes[ignored],
        })  # fmt: skip
    return labels


@dataclass(frozen=True)
class RtdetrJob(BoxJob):
    """A training of an RT-DETR."""

    config: RtdetrConfig

    run_config: ClassVar[type[BoxRun]] = RtdetrRun
    task: ClassVar[type[BoxTask]] = RtdetrTask

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.size == "tiny"

    def sizes(self, prepared: Prepared) -> RtdetrNetworkConfig:
        """Return the widths of the size, for the classes."""
        return RtdetrNetworkConfig(**SIZES[self.config.size], classes=len(prepared.classes))

    def begin_with(self, init: str | Path, started: Started, log: RunLog) -> StartingWeights:
        """Copy weights of another run, or of the library, and say how many fitted."""
        begun, remark = start_from(init, started.task.network)
        log.note(remark)
        return begun
