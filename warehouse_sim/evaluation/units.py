"""Whether predictions are in millimetres, seen from how far away they put things."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.reader import ImageRecord, TargetRecord
from warehouse_sim.errors import EvaluationError
from warehouse_sim.schema import PoseEstimate

_MISTAKEN = {"metres": 1e-3, "micrometres": 1e3}
"""Unit of t that a file may be in -> by how much that makes distances too small or large."""
_ALIKE = 3.0
"""Factor within which distances of estimates and ground truth agree; no estimator is wrong by hundreds in the
median."""


def check_unit(estimates: Sequence[PoseEstimate], images: Sequence[ImageRecord], file: str | Path) -> None:
    """Reject predictions whose distances from the camera are in another unit than millimetres.

    Args:
        estimates: Predictions, each of one of ``images``.
        images: Images with their targets.
        file: Where the predictions come from, for messages.

    Raises:
        EvaluationError: The median distance is that of the ground truth of the same images in another unit.
    """
    predicted = {(item.scene_id, item.image_id) for item in estimates}
    targets = [item for image in images if (image.scene_id, image.image_id) in predicted for item in image.targets]
    if not targets:
        return
    found, true = (float(np.median([_distance(item) for item in group])) for group in (estimates, targets))
    for unit, factor in _MISTAKEN.items():
        if true * factor / _ALIKE < found < true * factor * _ALIKE:
            raise EvaluationError(
                f"{file}: t looks like {unit}: read as millimetres, the estimates are {found:.3g} m from the camera in "
                f"the median, the ground truth of the same images is {true:.3g} m; multiply t by {1 / factor:g}"
            )


def _distance(item: PoseEstimate | TargetRecord) -> float:
    return float(np.linalg.norm(item.T_camera_object[:3, 3]))
