"""One training step of an RT-DETR; samples and validation are those of the package's own detector."""

import torch
from jaxtyping import Float
from torch import Tensor

from warehouse_sim.estimators.detection.assignment import Targets
from warehouse_sim.estimators.detection.training.task import ImageBoxTask, Inputs
from warehouse_sim.estimators.images.order import GroupedOrder
from warehouse_sim.estimators.rtdetr.estimator import RTDETR_DETECT
from warehouse_sim.estimators.rtdetr.loss import Labels, make_loss
from warehouse_sim.estimators.rtdetr.network import RtdetrNetwork
from warehouse_sim.estimators.rtdetr.settings import RtdetrConfig
from warehouse_sim.learning.array_store import Arrays
from warehouse_sim.learning.device import on_device


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
