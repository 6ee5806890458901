"""Which estimate answers for which ground truth, over all images of a split."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.reader import ImageRecord, TargetRecord
from warehouse_sim.evaluation.matching import match
from warehouse_sim.evaluation.pose_error import estimates_in_object, mssd
from warehouse_sim.evaluation.surface import ErrorModels
from warehouse_sim.schema import PoseEstimate


@dataclass(frozen=True, eq=False)
class Pair:
    """A ground truth that counts, with its estimate if it has one."""

    image: ImageRecord
    target: TargetRecord
    prediction: int
    """Row among the predictions, -1 for a miss."""


def pair_up(
    predictions: Sequence[PoseEstimate],
    images: Sequence[ImageRecord],
    models: ErrorModels,
    min_visible_fraction: float,
) -> list[Pair]:
    """Match the predictions of each image and object class by the rules of ``matching.match``.

    Args:
        predictions: Estimates of all images.
        images: Images with their targets.
        models: Where errors are measured.
        min_visible_fraction: Visible share (0-1) from which a ground truth counts.

    Returns:
        One pair a ground truth that counts.
    """
    by_place: dict[tuple[int, int, int], list[int]] = defaultdict(list)
    for index, prediction in enumerate(predictions):
        by_place[prediction.scene_id, prediction.image_id, prediction.obj_id].append(index)
    pairs = []
    for image in images:
        for obj_id in sorted({target.obj_id for target in image.targets}):
            targets = [target for target in image.targets if target.obj_id == obj_id]
            indices = by_place[image.scene_id, image.image_id, obj_id]
            estimates = [predictions[index] for index in indices]
            errors = _pairwise_errors(estimates, targets, models)
            counted = np.array(
                [target.visible_fraction >= min_visible_fraction and models.counts(target) for target in targets]
            )
            matched = match(errors, np.array([estimate.score for estimate in estimates]), counted)
            for position in np.flatnonzero(counted):
                row = matched[position]
                pairs.append(Pair(image, targets[position], indices[row] if row >= 0 else -1))
    return pairs


def _pairwise_errors(
    estimates: Sequence[PoseEstimate], targets: Sequence[TargetRecord], models: ErrorModels
) -> Float[np.ndarray, "p g"]:
    """MSSD of each estimate against each truth; a centre a diameter away is another object (as in BOP's scripts)."""
    if len(targets) > 1 and not models.info(targets[0]).has_cad:
        return np.concatenate([_pairwise_errors(estimates, [target], models) for target in targets], axis=1)
    info, points = models.info(targets[0]), models.points(targets[0])
    T_estimated = np.reshape([item.T_camera_object for item in estimates], (-1, 1, 4, 4))
    T_true = np.stack([item.T_camera_object for item in targets])[None]
    errors = mssd(estimates_in_object(T_estimated, T_true, info.symmetry), points.hull).min(axis=-1)
    distance = np.linalg.norm(T_estimated[..., :3, 3] - T_true[..., :3, 3], axis=-1)
    return np.where(distance < info.diameter, errors, np.inf)
