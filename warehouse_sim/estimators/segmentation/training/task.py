"""One training step and one validation of a segmenter."""

from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from warehouse_sim.estimators.segmentation.losses import keypoint_loss, mask_loss
from warehouse_sim.estimators.segmentation.networks.segmenter import SegmenterNetwork
from warehouse_sim.estimators.segmentation.peaks import find_peaks
from warehouse_sim.estimators.segmentation.sample import BoxSample, box_sample
from warehouse_sim.estimators.segmentation.settings import BoxCropConfig, SegmenterConfig
from warehouse_sim.learning.array_store import Arrays
from warehouse_sim.learning.loop import Task

_VALIDATION_BATCH = 32
_MOST_VALIDATED = 1000
"""Boxes of a validation, evenly spread."""


class BoxRows:
    """Rows of several arrays as one, of which only some are wanted.

    Args:
        parts: Arrays of each dataset.
        chosen: Which rows of each.
    """

    def __init__(self, parts: Sequence[Arrays], chosen: Sequence[Int[np.ndarray, " k"]]) -> None:
        self._parts = parts
        self._places = [(part, int(row)) for part, rows in enumerate(chosen) for row in rows]

    def __len__(self) -> int:
        return len(self._places)

    def at(self, index: int) -> tuple[Arrays, int]:
        """Return the arrays that hold a row, and its number there."""
        part, row = self._places[index]
        return self._parts[part], row


class SegmentationTask(Task):
    """Train masks, and key points where the network has them, on crops of boxes that are off.

    Args:
        network: What is trained.
        config: Settings.
        crop: How boxes are cut out.
        rows: Rows by split.
    """

    network: SegmenterNetwork

    def __init__(
        self, network: SegmenterNetwork, config: SegmenterConfig, crop: BoxCropConfig, rows: dict[str, BoxRows]
    ) -> None:
        super().__init__(network)
        self.config, self._crop, self._rows = config, crop, rows
        self._device = torch.device("cpu")

    def move_samples(self, device: torch.device) -> None:
        """Remember where batches go; crops stay on the disk."""
        self._device = device

    def forward(self, index: Int[Tensor, " b"], share: slice, step: int, fraction: float) -> Float[Tensor, ""]:
        """Return the loss on the boxes ``index``, disturbed afresh."""
        samples = list[BoxSample]()
        for place, row in list(enumerate(index.tolist()))[share]:
            rng = np.random.default_rng([self.config.seed, step, place])
            samples.append(box_sample(*self._rows["train"].at(row), self._crop, self.config.augment, rng))
        mask, places = self.network(*self._tensors(samples))
        with torch.autocast(self._device.type, enabled=False):
            loss = mask_loss(mask.float(), self._stacked([sample.mask for sample in samples]))
            if places.shape[1]:
                points = self._stacked([sample.points for sample in samples])
                loss = loss + self.config.keypoint_weight * keypoint_loss(places.float(), points)
        return loss

    def validate(self, network: nn.Module) -> dict[str, float]:
        """Return the mean overlap of masks with the truth, the shares (%) above 0.5 and 0.75, and errors of points."""
        assert isinstance(network, SegmenterNetwork)
        rows = self._rows["val"]
        chosen = range(0, len(rows), max(1, -(-len(rows) // _MOST_VALIDATED)))
        overlaps, errors = list[np.ndarray](), list[np.ndarray]()
        for start in range(0, len(chosen), _VALIDATION_BATCH):
            samples = [
                box_sample(*rows.at(row), self._crop, None, np.random.default_rng([0, row]))
                for row in chosen[start : start + _VALIDATION_BATCH]
            ]
            mask, places = network(*self._tensors(samples))
            found, truth = (mask > 0).cpu().numpy(), np.stack([sample.mask for sample in samples]) > 0.5
            union = (found | truth).sum(axis=(1, 2))
            overlaps.append((found & truth).sum(axis=(1, 2)) / np.maximum(union, 1))
            if places.shape[1]:
                points = np.stack([sample.points for sample in samples])
                distance = np.linalg.norm(find_peaks(places.float()).uv - points[..., :2], axis=2)
                errors.append(distance[points[..., 2] > 0])
        overlap = np.concatenate(overlaps)
        metrics = {"val_iou": 100.0 * float(overlap.mean())}
        metrics |= {f"val_iou_{int(100 * t)}": 100.0 * float((overlap >= t).mean()) for t in (0.5, 0.75)}
        if errors and (all_errors := np.concatenate(errors)).size:
            metrics["val_point_px"] = float(np.median(all_errors))
        return metrics

    def _tensors(self, samples: Sequence[BoxSample]) -> tuple[Tensor | None, Tensor | None, Tensor]:
        rgb = [sample.rgb for sample in samples if sample.rgb is not None]
        depth = [sample.depth for sample in samples if sample.depth is not None]
        width_rad = torch.tensor([sample.width_rad for sample in samples], dtype=torch.float32, device=self._device)
        return self._stacked(rgb) if rgb else None, self._stacked(depth) if depth else None, width_rad

    def _stacked(self, arrays: Sequence[np.ndarray]) -> Tensor:
        return torch.from_numpy(np.stack(arrays)).to(self._device)
