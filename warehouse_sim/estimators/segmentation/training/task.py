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
from warehouse_sim.learning.ahead import MadeAhead
from warehouse_sim.learning.array_store import Arrays
from warehouse_sim.learning.device import on_device
from warehouse_sim.learning.loop import Task
from warehouse_sim.learning.order import SampleOrder

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
        order: Order of the training samples.
    """

    network: SegmenterNetwork

    def __init__(
        self,
        network: SegmenterNetwork,
        config: SegmenterConfig,
        crop: BoxCropConfig,
        rows: dict[str, BoxRows],
        order: SampleOrder,
    ) -> None:
        super().__init__(network)
        self.config, self._crop, self._rows, self._order = config, crop, rows, order
        self._device = torch.device("cpu")
        self._samples = MadeAhead(self._disturbed, config.workers)

    def move_samples(self, device: torch.device) -> None:
        """Remember where batches go; crops stay on the disk."""
        self._device = device

    def forward(self, index: Int[Tensor, " b"], part: slice, step: int, fraction: float) -> Float[Tensor, ""]:
        """Return the loss on the boxes ``index``, disturbed afresh."""
        following = self._order.indices(step + 1)
        samples = self._samples.take(_keys(index, part, step), _keys(following, part, step + 1))
        mask, places = self.network(*self._tensors(samples))
        with torch.autocast(self._device.type, enabled=False):
            loss = mask_loss(mask.float(), self._stacked([sample.mask for sample in samples]))
            if places.shape[1]:
                points = self._stacked([sample.points for sample in samples])
                loss = loss + self.config.keypoint_weight * keypoint_loss(places.float(), points)
        return loss

    def _disturbed(self, key: tuple[int, int, int]) -> BoxSample:
        step, place, row = key
        rng = np.random.default_rng([self.config.seed, step, place])
        return box_sample(*self._rows["train"].at(row), self._crop, self.config.augment, rng)

    def validate(self, network: nn.Module) -> dict[str, float]:
        """Return the masks' mean overlap with ground truth, the fractions (%) above 0.5 and 0.75, errors of points."""
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
            found, gt = (mask > 0).cpu().numpy(), np.stack([sample.mask for sample in samples]) > 0.5
            union = (found | gt).sum(axis=(1, 2))
            overlaps.append((found & gt).sum(axis=(1, 2)) / np.maximum(union, 1))
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
        width_rad = np.array([sample.width_rad for sample in samples], dtype=np.float32)
        return self._stacked(rgb) if rgb else None, self._stacked(depth) if depth else None, self._moved(width_rad)

    def _stacked(self, arrays: Sequence[np.ndarray]) -> Tensor:
        return self._moved(np.stack(arrays))

    def _moved(self, array: np.ndarray) -> Tensor:
        return on_device(torch.from_numpy(array), self._device)


def _keys(index: Int[Tensor, " b"], part: slice, step: int) -> list[tuple[int, int, int]]:
    """Return what decides each sample: the step, its place in it, its row."""
    return [(step, place, row) for place, row in enumerate(index.tolist())][part]
