"""Average precision of detections, as COCO counts it: matched image by image, pooled over a class."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

RECALLS = np.linspace(0.0, 1.0, 101)
"""Where COCO reads the precision."""


@dataclass(frozen=True, eq=False)
class Matches:
    """The detections of one class in one image, best first, and whether each is right."""

    scores: Float[np.ndarray, " n"]
    right: Bool[np.ndarray, " n"]
    ignored: Bool[np.ndarray, " n"]
    """Neither right nor wrong: on what is not requested."""
    wanted: int
    """How many were to be found."""


def match(
    scores: Float[np.ndarray, " n"],
    overlaps: Float[np.ndarray, "n m"],
    wanted: Bool[np.ndarray, " m"],
    min_overlap: float,
) -> Matches:
    """Match the detections of an image greedily, the best score first, each with what it overlaps most.

    Args:
        scores: Of each detection.
        overlaps: Intersection over union of each detection with each true object; for what is not wanted, COCO takes
            the covered fraction of the detection, since it may stand for many.
        wanted: Which true objects are to be found; others may be found by any number of detections without harm.
        min_overlap: From here on a detection is right.
    """
    order = np.argsort(-scores, kind="stable")
    right, ignored = np.zeros(len(order), dtype=bool), np.zeros(len(order), dtype=bool)
    free = wanted.copy()
    for row, detection in enumerate(order):
        found = overlaps[detection]
        open_ones = np.where(free, found, -1.0)
        best = int(open_ones.argmax()) if open_ones.size else -1
        if best >= 0 and open_ones[best] >= min_overlap:
            right[row], free[best] = True, False
        else:
            ignored[row] = bool((found[~wanted] >= min_overlap).any())
    return Matches(scores[order], right, ignored, int(wanted.sum()))


def average_precision(images: list[Matches]) -> float:
    """Return the mean precision over recalls of 0, 0.01, ... 1; NaN where there was nothing to find."""
    wanted = sum(item.wanted for item in images)
    if not wanted:
        return float("nan")
    precision, recall, _ = precision_recall(images)
    # Precision at a recall is the best at that recall or a higher one.
    best = np.maximum.accumulate(precision[::-1])[::-1]
    places = np.searchsorted(recall, RECALLS, side="left")
    return float(np.where(places < len(best), np.append(best, 0.0)[np.minimum(places, len(best))], 0.0).mean())


def precision_recall(images: list[Matches]) -> tuple[Float[np.ndarray, " n"], ...]:
    """Return precision, recall and score, detection by detection, the best score first."""
    wanted = sum(item.wanted for item in images)
    counted = [(item.scores[~item.ignored], item.right[~item.ignored]) for item in images]
    scores = np.concatenate([scores for scores, _ in counted] or [np.zeros(0)])
    right = np.concatenate([right for _, right in counted] or [np.zeros(0, dtype=bool)])
    order = np.argsort(-scores, kind="mergesort")
    hits = np.cumsum(right[order])
    return hits / np.arange(1, len(hits) + 1), hits / max(wanted, 1), scores[order]
