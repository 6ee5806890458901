"""Anchors for the boxes of a dataset: K-means over their widths and heights, so that wide pallets get wide anchors."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

FITS = 4.0
"""An anchor is assigned boxes whose width and height differ from its own by less than this factor."""
_ROUNDS = 50


class AnchorFit(NamedTuple):
    """Anchors, and how well they fit."""

    anchors_wh: Float[np.ndarray, "a 2"]
    """Width and height (px), by area."""
    recall: float
    """Fraction of the boxes that some anchor fits, 0-1."""


def cluster_anchors(boxes_wh: Float[np.ndarray, "k 2"], count: int, rng: np.random.Generator) -> AnchorFit:
    """Return anchors by K-means over the logarithms of widths and heights: what counts are ratios.

    Args:
        boxes_wh: Sizes of at least one box (px).
        count: Number of anchors.
        rng: Draws the first centres (Arthur & Vassilvitskii, "k-means++", SODA 2007).
    """
    points = np.log(np.maximum(np.asarray(boxes_wh, dtype=float), 1.0))
    centres = _first_centres(points, count, rng)
    for _ in range(_ROUNDS):
        nearest = ((points[:, None] - centres) ** 2).sum(axis=2).argmin(axis=1)
        moved = np.array([
            points[nearest == i].mean(axis=0) if (nearest == i).any() else centres[i] for i in range(count)
        ])  # fmt: skip
        if np.allclose(moved, centres):
            break
        centres = moved
    anchors = np.exp(centres)
    anchors = anchors[anchors.prod(axis=1).argsort(kind="stable")]
    return AnchorFit(anchors, anchor_recall(boxes_wh, anchors))


def anchor_recall(boxes_wh: Float[np.ndarray, "k 2"], anchors_wh: Float[np.ndarray, "a 2"]) -> float:
    """Return the fraction of boxes that some anchor fits."""
    ratio = np.maximum(boxes_wh, 1.0)[:, None] / anchors_wh
    worst = np.maximum(ratio, 1.0 / ratio).max(axis=2)
    return float((worst.min(axis=1) < FITS).mean())


def _first_centres(points: Float[np.ndarray, "k 2"], count: int, rng: np.random.Generator) -> Float[np.ndarray, "c 2"]:
    centres = [points[rng.integers(len(points))]]
    while len(centres) < count:
        distance = ((points[:, None] - np.array(centres)) ** 2).sum(axis=2).min(axis=1)
        total = distance.sum()
        # Fewer different boxes than anchors: the rest are spread about one of them.
        chosen = rng.choice(len(points), p=distance / total) if total > 0 else rng.integers(len(points))
        centres.append(points[chosen] + (0.0 if total > 0 else rng.normal(0.0, 0.2, 2)))
    return np.array(centres)
