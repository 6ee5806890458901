"""Non-maximum suppression: of boxes of one class that overlap, the best stays."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.geometry.overlap import box_ious

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
    least_score: float = 0.25,
    most_overlap: float = 0.6,
    most_boxes: int = 300,
) -> Kept:
    """Return the boxes that no better one of their class overlaps.

    Args:
        boxes: Left, top, right, bottom.
        scores: Of each class, 0-1; a box may stay for several.
        least_score: Boxes below it are left out.
        most_overlap: Largest intersection over union with a better box of the class.
        most_boxes: How many remain at most.
    """
    rows, classes = np.nonzero(scores > least_score)
    values = scores[rows, classes]
    best = np.argsort(-values, kind="stable")[:CONSIDERED]
    rows, classes, values = rows[best], classes[best], values[best]
    found = boxes[rows]
    alike = (box_ious(found, found) > most_overlap) & (classes[:, None] == classes)
    stays = np.ones(len(rows), dtype=bool)
    kept = list[int]()
    for number in range(len(rows)):
        if stays[number]:
            kept.append(number)
            if len(kept) == most_boxes:
                break
            stays &= ~alike[number]
    return Kept(found[kept], values[kept], classes[kept], rows[kept])
