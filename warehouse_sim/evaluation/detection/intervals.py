"""Intervals of detections' average precision: whole scenes are drawn again, as images of one are alike."""

from collections.abc import Sequence

import numpy as np

from warehouse_sim.evaluation.detection.scores import OVERLAPS, Seen
from warehouse_sim.geometry.precision_recall import average_precision, match


def precision_intervals(
    parts: Sequence[Seen], resamples: int, rng: np.random.Generator
) -> dict[str, tuple[float, float, float]]:
    """Return average precision (0-1) and the ends of its 95 % interval by name: box_50, box_75, mask_50, mask_75.

    Percentiles of a bootstrap over scenes (Cameron, Gelbach and Miller 2008: resample clusters, not rows). It has no
    width where every scene has the same score.

    Args:
        parts: Of one class, image by image.
        resamples: Bootstrap resamples.
        rng: Source of the resamples.
    """
    scenes = sorted({item.scene_id for item in parts})
    picks = rng.integers(len(scenes), size=(resamples, len(scenes)))
    kinds = ["box"] if any(item.masks is None for item in parts) else ["box", "mask"]
    found: dict[str, tuple[float, float, float]] = {}
    for kind in kinds:
        for overlap in OVERLAPS:
            pairs = [(item.boxes if kind == "box" else item.masks) for item in parts]
            matches = [
                match(item.scores, np.asarray(pair), item.wanted, overlap)
                for item, pair in zip(parts, pairs, strict=True)
            ]
            of_scene = [[m for m, item in zip(matches, parts, strict=True) if item.scene_id == s] for s in scenes]
            sampled = [average_precision([m for number in row for m in of_scene[number]]) for row in picks]
            low, high = np.nanpercentile(sampled, [2.5, 97.5])
            found[f"{kind}_{round(100 * overlap)}"] = average_precision(matches), float(low), float(high)
    return found
