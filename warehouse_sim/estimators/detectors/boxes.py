"""Which boxes of a network remain (non-maximum suppression), and how good these are."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.dataset.results.precision_recall import Matches, average_precision, match
from warehouse_sim.geometry.boxes import box_coverage, box_ious

CONSIDERED = 1000
"""Of more boxes, those with the best scores."""


class Kept(NamedTuple):
    """Boxes that remain, the best first."""

    boxes: Float[np.ndarray, "k 4"]
    scores: Float[np.ndarray, " k"]
    classes: Int[np.ndarray, " k"]
    rows: Int[np.ndarray, " k"]
    """Which of the given boxes they are."""


def suppress(
    boxes: Float[np.ndarray, "n 4"],
    scores: Float[np.ndarray, "n c"],
    min_score: float = 0.25,
    max_overlap: float = 0.6,
    most_boxes: int = 300,
) -> Kept:
    """Return the boxes that no better one of their class overlaps.

    Args:
        boxes: Left, top, right, bottom.
        scores: Of each class, 0-1; a box may stay for several.
        min_score: Boxes below it are left out.
        max_overlap: Largest intersection over union with a better box of the class.
        most_boxes: How many remain at most.
    """
    rows, classes = np.nonzero(scores > min_score)
    values = scores[rows, classes]
    best = np.argsort(-values, kind="stable")[:CONSIDERED]
    rows, classes, values = rows[best], classes[best], values[best]
    found = boxes[rows]
    alike = (box_ious(found, found) > max_overlap) & (classes[:, None] == classes)
    stays = np.ones(len(rows), dtype=bool)
    kept = list[int]()
    for number in range(len(rows)):
        if stays[number]:
            kept.append(number)
            if len(kept) == most_boxes:
                break
            stays &= ~alike[number]
    return Kept(found[kept], values[kept], classes[kept], rows[kept])


def voted(kept: Kept, boxes: Float[np.ndarray, "n 4"], scores: Float[np.ndarray, "n c"], min_overlap: float) -> Kept:
    """Return boxes whose edges are the mean of all that a network gave in their place, weighted by score and overlap.

    Source: box voting (Gidaris and Komodakis, ICCV 2015).

    Args:
        kept: What ``suppress`` kept.
        boxes: All boxes.
        scores: Of each class, 0-1.
        min_overlap: Intersection over union with what was kept from which on a box is in its place.
    """
    overlap = box_ious(kept.boxes, boxes)
    # A box without an area overlaps nothing, not even itself.
    overlap[np.arange(len(kept.rows)), kept.rows] = 1.0
    weights = np.where(overlap >= min_overlap, overlap * scores.T[kept.classes], 0.0)
    return kept._replace(boxes=weights @ boxes / weights.sum(axis=1, keepdims=True))


def fuse(looks: Sequence[Kept], min_score: float, min_overlap: float) -> Kept:
    """Return one box for what several looks at an image found, the best first.

    Of each look, the best box of a class that overlaps the best one of all is taken; edges are their mean, weighted by
    score, and the score is the mean over all looks, 0 where one found nothing (weighted boxes fusion: Solovyev et al.,
    Image and Vision Computing 2021).

    Args:
        looks: What each found.
        min_score: Boxes with a lower mean score are left out.
        min_overlap: Intersection over union from which on boxes of two looks are of one object.
    """
    boxes, scores = np.concatenate([look.boxes for look in looks]), np.concatenate([look.scores for look in looks])
    classes = np.concatenate([look.classes for look in looks])
    look_of = np.repeat(np.arange(len(looks)), [len(look.scores) for look in looks])
    best = np.argsort(-scores, kind="stable")
    alike = (box_ious(boxes, boxes) > min_overlap) & (classes[:, None] == classes)
    free = np.ones(len(scores), dtype=bool)
    found = list[tuple[Float[np.ndarray, " 4"], float, int, int]]()
    for row in best:
        if not free[row]:
            continue
        group = best[alike[row, best] & free[best]]
        free[group] = False
        _, first = np.unique(look_of[group], return_index=True)
        taken = group[np.sort(first)]
        weights = scores[taken]
        mean = float(weights.sum()) / len(looks)
        if mean > min_score:
            found.append((weights @ boxes[taken] / weights.sum(), mean, int(classes[row]), int(row)))
    found.sort(key=lambda item: -item[1])
    return Kept(
        np.array([item[0] for item in found]).reshape(-1, 4),
        np.array([item[1] for item in found]),
        np.array([item[2] for item in found], dtype=int),
        np.array([item[3] for item in found], dtype=int),
    )


def helped(first: Kept, other: Kept, weight: float, min_overlap: float) -> Kept:
    """Return what a detector found with the help of another one, the best first; scores are the weighted mean of both.

    Each box of the first, the best one first, is joined by the box of the other that overlaps it most; edges are their
    mean, weighted by score. What only one of them found stays, with a score of 0 by the other.

    Args:
        first: What the detector found, with scores above 0.
        other: What the other one found, of the same classes.
        weight: How much the other one counts beside the first, above 0.
        min_overlap: Intersection over union from which on boxes of both are of one object.
    """
    overlap = np.where(first.classes[:, None] == other.classes, box_ious(first.boxes, other.boxes), 0.0)
    edges, scores = first.boxes * first.scores[:, None], first.scores.copy()
    free = np.ones(len(other.scores), dtype=bool)
    for row in np.argsort(-first.scores, kind="stable"):
        near = np.where(free, overlap[row], 0.0)
        if near.size and near.max() > min_overlap:
            mate = int(near.argmax())
            free[mate] = False
            share = weight * other.scores[mate]
            edges[row] += share * other.boxes[mate]
            scores[row] += share
    boxes = np.concatenate([edges / scores[:, None], other.boxes[free]])
    scores = np.concatenate([scores, weight * other.scores[free]]) / (1.0 + weight)
    best = np.argsort(-scores, kind="stable")
    classes = np.concatenate([first.classes, other.classes[free]])
    rows = np.concatenate([first.rows, len(first.rows) + other.rows[free]])
    return Kept(boxes[best], scores[best], classes[best], rows[best])


def box_precision(
    found: Sequence[Kept],
    boxes: Sequence[Float[np.ndarray, "m 4"]],
    classes: Sequence[np.ndarray],
    wanted: Sequence[Bool[np.ndarray, " m"]],
    class_count: int,
    min_overlap: float,
) -> float:
    """Return the mean over classes of the average precision, in percent; classes that never occur do not count.

    Args:
        found: What was detected in each image.
        boxes: Ground-truth boxes of each image, in the same coordinates.
        classes: Their classes.
        wanted: Which of them are to be found.
        class_count: Number of classes.
        min_overlap: Intersection over union from which on a detection is right.
    """
    values = list[float]()
    for number in range(class_count):
        rows = list[Matches]()
        for kept, gt, labels, requested in zip(found, boxes, classes, wanted, strict=True):
            mine, theirs = kept.classes == number, labels == number
            box, gt_box, is_requested = kept.boxes[mine], gt[theirs], requested[theirs]
            overlap = np.where(is_requested, box_ious(box, gt_box), box_coverage(box, gt_box))
            rows.append(match(kept.scores[mine], overlap, is_requested, min_overlap))
        values.append(average_precision(rows))
    known = [value for value in values if not np.isnan(value)]
    return 100.0 * float(np.mean(known)) if known else 0.0
