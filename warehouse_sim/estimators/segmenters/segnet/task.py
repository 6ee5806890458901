"""One training step and one validation of a segmenter: samples, losses, scores."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import torch
from jaxtyping import Float, Float32, Int, UInt8
from torch import Tensor, nn
from torch.nn import functional

from warehouse_sim.estimators.images.compose import ImageErrors, Sample, disturbed
from warehouse_sim.estimators.segmenters.segnet.keypoints import MIRRORED, find_peaks
from warehouse_sim.estimators.segmenters.segnet.network import Said, SegmenterNetwork
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig, SegmenterConfig
from warehouse_sim.estimators.segmenters.segnet.window import Window
from warehouse_sim.learning.loop import ComposedTask, Order
from warehouse_sim.learning.samples.array_store import Arrays

_SPREAD_PX = 1.5
"""Of the place that a key point is requested."""
_KEYPOINT_WEIGHT = 0.05
"""Of key points against the mask, for networks that find them."""
_KIND_WEIGHT = 0.3
"""Of kinds against the mask, for networks that tell them apart."""
_BOX_ERROR = np.array([0.1, 0.15])
"""Standard deviation of where the sides of a box are, left and right, top and bottom, as a fraction of its size: those
of ``detector-depth-warehouses`` where its boxes overlap by half (0.07-0.10, 0.12-0.16)."""
_MOST_OFF, _FLIP = 0.35, 0.5
"""How far a side is off at most, and which fraction of crops is mirrored."""
_ERRORS = ImageErrors(depth_noise=0.001, depth_holes=3, depth_scale=0.02)


def mask_loss(logits: Float[Tensor, "b h w"], gt: Float[Tensor, "b h w"]) -> Float[Tensor, ""]:
    """Return binary cross entropy and 1 - Dice (Milletari et al., "V-Net", 3DV 2016)."""
    cross = functional.binary_cross_entropy_with_logits(logits, gt)
    chance = torch.sigmoid(logits)
    shared = (chance * gt).sum(dim=(1, 2))
    dice = 2.0 * shared / (chance.sum(dim=(1, 2)) + gt.sum(dim=(1, 2))).clamp(min=1.0)
    return cross + (1.0 - dice).mean()


def keypoint_loss(logits: Float[Tensor, "b k h w"], points: Float[Tensor, "b k 3"]) -> Float[Tensor, ""]:
    """Return the cross entropy of a map over all places with a narrow peak at the ground truth, of visible points."""
    _, _, height, width = logits.shape
    rows = torch.arange(height, device=logits.device, dtype=logits.dtype)
    columns = torch.arange(width, device=logits.device, dtype=logits.dtype)
    across = -((columns - points[..., :1]) ** 2) / (2 * _SPREAD_PX**2)
    down = -((rows - points[..., 1:2]) ** 2) / (2 * _SPREAD_PX**2)
    wanted = torch.softmax((down[..., :, None] + across[..., None, :]).flatten(2), dim=2)
    cross = -(wanted * torch.log_softmax(logits.flatten(2), dim=2)).sum(dim=2)
    there = points[..., 2]
    return (cross * there).sum() / there.sum().clamp(min=1.0)


def kind_loss(logits: Float[Tensor, "b k"], kinds: Int[Tensor, " b"]) -> Float[Tensor, ""]:
    """Return the cross entropy of kinds, those of -1 left out; each kind of the batch counts the same.

    So what is likely is what is seen, and not what is frequent: who asks knows which objects there are.
    """
    known = kinds >= 0
    if not known.any():
        return logits.sum() * 0.0
    cross = functional.cross_entropy(logits[known], kinds[known], reduction="none")
    count = torch.bincount(kinds[known], minlength=logits.shape[1])
    weight = 1.0 / count[kinds[known]]
    return (cross * weight).sum() / weight.sum()


@dataclass(frozen=True, eq=False)
class BoxSample:
    """One crop with its ground truth."""

    rgb: UInt8[np.ndarray, "h w 3"] | None
    depth: Float32[np.ndarray, "h w"] | None
    """Metres, 0 = no reading."""
    width_rad: float
    """Width of the crop over the focal length."""
    mask: Float32[np.ndarray, "h w"]
    points: Float32[np.ndarray, "p 3"]
    """Key points (px) with 1 where they are in the crop."""
    obj_id: int


def box_sample(arrays: Arrays, index: int, config: BoxCropConfig, augment: bool, rng: np.random.Generator) -> BoxSample:
    """Return a stored crop as a network sees it.

    Args:
        arrays: Stored rows.
        index: Which of them.
        config: How boxes are cut out.
        augment: Whether the crop is disturbed; else only its box is moved.
        rng: Decides.
    """
    width, height = config.stored_wh
    fraction = 1.0 / (1.0 + 2.0 * config.stored_margin)
    size = np.array([width, height]) * fraction
    # Half of the boxes are nearly right: a segmenter looks again where its first mask says that the object is.
    off = rng.normal(size=(2, 2)) * _BOX_ERROR * (1.0 if rng.random() < 0.5 else 0.3)
    off = np.clip(off, -_MOST_OFF, _MOST_OFF) * size
    low, high = (np.array([width, height]) + np.array([[-1], [1]]) * size) / 2 + off
    window = Window.about((low[0], low[1], high[0], high[1]), config.margin, config.crop_wh)
    mirrored = augment and bool(rng.random() < _FLIP)
    rgb = window.smooth(np.asarray(arrays["rgb"][index]), mirrored) if "rgb" in arrays else None
    depth = None
    if "depth" in arrays:
        depth = window.picked(np.asarray(arrays["depth"][index]), mirrored).astype(np.float32) / 1000.0
    if augment:
        noisy = disturbed(Sample(rgb, depth, np.zeros((0, 8), dtype=np.float32)), _ERRORS, rng)
        rgb, depth = noisy.rgb, noisy.depth
    mask = window.picked(np.asarray(arrays["mask"][index]), mirrored).astype(np.float32)
    points = np.array(arrays["points"][index])
    points[:, :2] = window.to_crop(points[:, :2].astype(float), mirrored)
    if mirrored:
        points = points[list(MIRRORED)]
    inside = ((points[:, :2] > -0.5) & (points[:, :2] < np.array(config.crop_wh) - 0.5)).all(axis=1)
    points[:, 2] *= inside
    stored_rad = float(arrays["facts"][index, 3]) / fraction / width
    width_rad = stored_rad * (window.edges[2] - window.edges[0])
    return BoxSample(rgb, depth, width_rad, mask, points, int(arrays["facts"][index, 0]))


_VALIDATION_BATCH = 32
_MOST_VALIDATED = 1000
"""Boxes of a validation, evenly spread."""


class Boxes(Protocol):
    """Stored boxes by number."""

    def at(self, index: int, /) -> tuple[Arrays, int]:
        """Return the arrays that hold a box, and its row there."""


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


class SegmentationTask(ComposedTask[tuple[int, int, int], BoxSample]):
    """Train masks, and key points and kinds where the network has them, on crops of boxes that are off.

    Args:
        network: What is trained.
        config: Settings.
        crop: How boxes are cut out.
        train: Boxes to learn from.
        val: Those to validate on.
        order: Order of the training samples.
        kinds: Which kind an object is, by obj_id.
    """

    network: SegmenterNetwork

    def __init__(
        self,
        network: SegmenterNetwork,
        config: SegmenterConfig,
        crop: BoxCropConfig,
        train: Boxes,
        val: BoxRows,
        order: Order,
        kinds: Mapping[int, int],
    ) -> None:
        super().__init__(network, config.workers)
        self.config, self._crop, self._train, self._val, self._order = config, crop, train, val, order
        self._kinds = kinds

    def forward(self, index: Int[Tensor, " b"], part: slice, step: int, fraction: float) -> Float[Tensor, ""]:
        """Return the loss on the boxes ``index``, disturbed afresh."""
        following = self._order.indices(step + 1)
        samples = self._samples.take(_keys(index, part, step), _keys(following, part, step + 1))
        said: Said = self.network(*self._tensors(samples))
        with torch.autocast(self._device.type, enabled=False):
            loss = mask_loss(said.mask.float(), self.stacked([sample.mask for sample in samples]))
            if said.places.shape[1]:
                points = self.stacked([sample.points for sample in samples])
                loss = loss + _KEYPOINT_WEIGHT * keypoint_loss(said.places.float(), points)
            if said.kinds.shape[1]:
                loss = loss + _KIND_WEIGHT * kind_loss(said.kinds.float(), self._kinds_of(samples))
        return loss

    def compose(self, key: tuple[int, int, int]) -> BoxSample:
        """Return the training sample of a step, a place in it and a row."""
        step, place, row = key
        rng = np.random.default_rng([self.config.seed, step, place])
        return box_sample(*self._train.at(row), self._crop, True, rng)

    def validate(self, network: nn.Module) -> dict[str, float]:
        """Return the masks' mean overlap with ground truth, the fractions (%) above 0.5 and 0.75, errors of points."""
        assert isinstance(network, SegmenterNetwork)
        rows = self._val
        chosen = range(0, len(rows), max(1, -(-len(rows) // _MOST_VALIDATED)))
        overlaps, errors, told = list[np.ndarray](), list[np.ndarray](), list[np.ndarray]()
        for start in range(0, len(chosen), _VALIDATION_BATCH):
            samples = [
                box_sample(*rows.at(row), self._crop, False, np.random.default_rng([0, row]))
                for row in chosen[start : start + _VALIDATION_BATCH]
            ]
            mask, places, kinds = network(*self._tensors(samples))
            if kinds.shape[1]:
                right = self._kinds_of(samples)
                told.append((kinds.argmax(dim=1) == right)[right >= 0].cpu().numpy())
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
        if told and (all_told := np.concatenate(told)).size:
            metrics["val_kind"] = 100.0 * float(all_told.mean())
        return metrics

    def _kinds_of(self, samples: Sequence[BoxSample]) -> Int[Tensor, " b"]:
        """Return the number of each sample's kind, -1 of what is none of them."""
        return torch.tensor([self._kinds.get(sample.obj_id, -1) for sample in samples], device=self._device)

    def _tensors(self, samples: Sequence[BoxSample]) -> tuple[Tensor | None, Tensor | None, Tensor]:
        rgb = [sample.rgb for sample in samples if sample.rgb is not None]
        depth = [sample.depth for sample in samples if sample.depth is not None]
        width_rad = self.stacked([np.asarray(sample.width_rad, dtype=np.float32) for sample in samples])
        return self.stacked(rgb) if rgb else None, self.stacked(depth) if depth else None, width_rad


def _keys(index: Int[Tensor, " b"], part: slice, step: int) -> list[tuple[int, int, int]]:
    """Return what decides each sample: the step, its place in it, its row."""
    return [(step, place, row) for place, row in enumerate(index.tolist())][part]
