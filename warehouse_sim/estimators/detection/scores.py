"""Average precision of what a network detects, against labels as the store keeps them."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.detection.nms import Kept
from warehouse_sim.geometry.overlap import box_coverage, box_ious
from warehouse_sim.geometry.precision_recall import Matches, average_precision, match


def box_precision(
    found: Sequence[Kept],
    boxes: Sequence[Float[np.ndarray, "m 4"]],
    classes: Sequence[np.ndarray],
    wanted: Sequence[Bool[np.ndarray, " m"]],
    class_count: int,
    least_overlap: float,
) -> float:
    """Return the mean over classes of the average precision, in percent; classes that never occur do not count.

    Args:
        found: What was detected in each image.
        boxes: Ground-truth boxes of each image, in the same coordinates.
        classes: Their classes.
        wanted: Which of them are to be found.
        class_count: Number of classes.
        least_overlap: Intersection over union from which on a detection is right.
    """
    values = list[float]()
    for number in range(class_count):
        rows = list[Matches]()
        for kept, gt, labels, requested in zip(found, boxes, classes, wanted, strict=True):
            mine, theirs = kept.classes == number, labels == number
            box, gt_box, is_requested = kept.boxes[mine], gt[theirs], requested[theirs]
            overlap = np.where(is_requested, box_ious(box, gt_box), box_coverage(box, gt_box))
            rows.append(match(kept.scores[mine], overlap, is_requested, least_overlap))
        values.append(average_precision(rows))
    known = [value for value in values if not np.isnan(value)]
    return 100.0 * float(np.mean(known)) if known else 0.0
