"""The library's loss, with boxes of which nothing is learnt: neither that they are there nor that they are not."""

from collections.abc import Callable
from typing import Any

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from warehouse_sim.estimators.detectors.rtdetr.network import EXTRA, PURPOSE, Found
from warehouse_sim.optional import require

_COVERED = 0.5
"""Fraction of a box that lies in one of which nothing is learnt, from which on it may be that one."""
_NEVER = -30.0
"""Logit that teaches nothing where nothing is to be found."""
Labels = list[dict[str, Tensor]]
"""Of each image ``class_labels`` (k), ``boxes`` (k 4) and ``ignored`` (n 4); centre and size, fractions of the
canvas."""
Loss = Callable[[Found, Labels], Float[Tensor, ""]]


_WEIGHTS = {"loss_vfl": 1.0, "loss_bbox": 5.0, "loss_giou": 2.0}
"""Of varifocal loss, of differences of centres and sizes, and of 1 - GIoU: the library's own."""


def make_loss(library_config: Any) -> Loss:
    """Return what gives the loss of a batch: that of the last layer, of those before it, and of denoised boxes.

    Zhao et al., "DETRs beat YOLOs on real-time object detection", CVPR 2024. The library's own function lets the
    boxes that are to be denoised compete for the targets of the last layer, where they always win; here they do not.

    Raises:
        MissingPackageError: The library is not installed.
    """
    criterion = _criterion(library_config)
    criterion.weight_dict = _WEIGHTS

    def loss(found: Found, labels: Labels) -> Float[Tensor, ""]:
        parts: dict[str, Tensor] = criterion(_by_layer(found), labels)
        return torch.stack(list(parts.values())).sum()

    return loss


def _by_layer(found: Found) -> dict[str, Any]:
    """Return the output of each layer as the library's criterion wants it; boxes to be denoised come first."""
    groups: Any = found.denoising
    start = groups["dn_num_split"][0] if groups else 0
    layers = [_pair(logits[:, start:], boxes[:, start:]) for logits, boxes in found.layers]
    outputs: dict[str, Any] = {**layers[-1], "auxiliary_outputs": [*layers[:-1], _pair(*found.first)]}
    if groups:
        outputs["dn_auxiliary_outputs"] = [_pair(logits[:, :start], boxes[:, :start]) for logits, boxes in found.layers]
        outputs["denoising_meta_values"] = groups
    return outputs


def _pair(logits: Tensor, boxes: Tensor) -> dict[str, Tensor]:
    return {"logits": logits, "pred_boxes": boxes}


def _criterion(library_config: Any) -> Any:
    module = require("transformers.loss.loss_rt_detr", EXTRA, PURPOSE)

    class Matcher(module.RTDetrHungarianMatcher):
        """The library's, which cannot take a batch without any target."""

        def forward(self, outputs: Any, targets: Labels) -> list[tuple[Tensor, Tensor]]:
            if any(len(target["boxes"]) for target in targets):
                found: list[tuple[Tensor, Tensor]] = super().forward(outputs, targets)
                return found
            return [(torch.zeros(0, dtype=torch.int64), torch.zeros(0, dtype=torch.int64)) for _ in targets]

    class Criterion(module.RTDetrLoss):
        """The library's, but for boxes of which nothing is learnt."""

        def __init__(self, config: Any) -> None:
            super().__init__(config)
            self.matcher = Matcher(config)

        def loss_labels_vfl(self, outputs: Any, targets: Labels, indices: Any, *more: Any, **named: Any) -> Any:
            boxes = outputs["pred_boxes"].detach()
            free = torch.stack([covered(mine, them["ignored"]) for mine, them in zip(boxes, targets, strict=True)])
            free[self._get_source_permutation_idx(indices)] = False
            logits = outputs["logits"].masked_fill(free[..., None], _NEVER)
            return super().loss_labels_vfl({**outputs, "logits": logits}, targets, indices, *more, **named)

    return Criterion(library_config)


def covered(boxes: Float[Tensor, "n 4"], others: Float[Tensor, "k 4"]) -> Bool[Tensor, " n"]:
    """Return which boxes (centre and size) lie at least half in one of the others."""
    if not len(others):
        return torch.zeros(len(boxes), dtype=torch.bool, device=boxes.device)
    low, high = boxes[:, None, :2] - boxes[:, None, 2:] / 2, boxes[:, None, :2] + boxes[:, None, 2:] / 2
    other_low, other_high = others[:, :2] - others[:, 2:] / 2, others[:, :2] + others[:, 2:] / 2
    shared = (torch.minimum(high, other_high) - torch.maximum(low, other_low)).clamp(min=0).prod(dim=2)
    fraction = shared / boxes[:, None, 2:].prod(dim=2).clamp(min=1e-9)
    return (fraction >= _COVERED).any(dim=1)
