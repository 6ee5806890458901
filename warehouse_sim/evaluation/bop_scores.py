"""The scores of the BOP challenges: average recall of objects to be located, average precision of objects to be found.

MSSD counts from 5 to 50 % of the diameter, and for BOP 2025's industrial datasets from 2 to 20 mm; MSPD from 5 to 50 px
of an image 640 px wide. Recall (BOP 2019, Hodan et al., ECCVW 2020) takes as many estimates as there are instances and
pools all objects; precision (BOP 2024, Nguyen et al., 2025) takes up to 100 an image, ranks those of one object over
all images, and is the mean over objects. VSD, the third part of the challenges' AR, is measured on request: it takes
longest, and needs depth images.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.files.record import Record
from warehouse_sim.dataset.reader import ImageRecord, TargetRecord
from warehouse_sim.dataset.results.precision_recall import Matches, average_precision
from warehouse_sim.evaluation.errors.pose_error import mspd
from warehouse_sim.evaluation.errors.surface import ErrorModels
from warehouse_sim.evaluation.errors.visible_surface import BOP_TAUS, SeenDepth, vsd_errors
from warehouse_sim.evaluation.pairing import ErrorOf, Group, group_by_object, mssd_if_near, pairwise_errors
from warehouse_sim.evaluation.stated import STATED, Number
from warehouse_sim.geometry.pose import Transforms
from warehouse_sim.schema import PoseEstimate

THRESHOLDS = tuple(step / 20 for step in range(1, 11))
"""Of MSSD over the diameter, and of MSPD over 100 px of an image 640 px wide."""
THRESHOLDS_MM = tuple(range(2, 21, 2))
"""Of MSSD (mm)."""
_MOST_IN_IMAGE = 100


@dataclass(frozen=True)
class BopScores(Record):
    """All 0-1; nan where nothing was to be found."""

    ar_mssd: Number = field(metadata=STATED)
    """Average recall by MSSD."""
    ar_mspd: Number = field(metadata=STATED)
    """Average recall by MSPD."""
    ap_mssd: Number = field(metadata=STATED)
    """Mean average precision by MSSD; alone it is the score of BOP 2025."""
    ap_mspd: Number = field(metadata=STATED)
    """Mean average precision by MSPD."""
    ap: Number = field(metadata=STATED)
    """The mean of these two: the score of BOP 2024's detection tasks."""
    ap_mssd_mm: Number = field(metadata=STATED)
    """Mean average precision by MSSD from 2 to 20 mm: what BOP 2025 gives beside it."""
    ar_vsd: Number | None = field(default=None, metadata=STATED | {"omitted": True})
    """Average recall by VSD, over ten tolerances and ten thresholds; None where it was not requested."""
    ar: Number | None = field(default=None, metadata=STATED | {"omitted": True})
    """The mean of the three recalls: the score of BOP 2019 to 2023."""


def bop_scores(
    predictions: Sequence[PoseEstimate],
    images: Sequence[ImageRecord],
    models: ErrorModels,
    min_visible: float = 0.1,
    seen: SeenDepth | None = None,
) -> BopScores:
    """Score estimates as the challenges do.

    Args:
        predictions: Estimates of all images; those of objects that an image lacks do not count, as in the reference.
        images: Images with their targets.
        models: Where errors are measured.
        min_visible: Fraction (0-1) that must be seen of what is to be found; what is found on less does not count.
        seen: Reads depth images, for recall by VSD; None leaves that out.
    """
    kept = _best_of_each_image(predictions)
    to_locate, to_detect = group_by_object(predictions, images), group_by_object(kept, images)
    located, detected = {}, {}
    for name, error_of in {"mssd": _over_diameter(models), "mspd": _over_width(models)}.items():
        located[name] = detected[name] = pairwise_errors(to_locate, predictions, error_of, models)
        if len(kept) < len(predictions):
            detected[name] = pairwise_errors(to_detect, kept, error_of, models)
    surfaces = None if seen is None else vsd_errors(to_locate, predictions, models, seen)
    locate = [_Wanted.of(group, predictions, min_visible) for group in to_locate]
    detect = [_Wanted.of(group, kept, min_visible) for group in to_detect]
    recall = {name: _average_recall(locate, [of]) for name, of in located.items()}
    precision = {name: _mean_precision(detect, of, THRESHOLDS) for name, of in detected.items()}
    diameters = [models.info(group.targets[0]).diameter for group in to_detect]
    in_mm = [1000.0 * d * errors for d, errors in zip(diameters, detected["mssd"], strict=True)]
    ar_vsd = ar = None
    if surfaces is not None:
        by_tolerance = [[found[..., tau] for found in surfaces] for tau in range(len(BOP_TAUS))]
        ar_vsd = _average_recall(locate, by_tolerance)
        ar = (ar_vsd + recall["mssd"] + recall["mspd"]) / 3.0
    return BopScores(
        recall["mssd"],
        recall["mspd"],
        precision["mssd"],
        precision["mspd"],
        (precision["mssd"] + precision["mspd"]) / 2.0,
        _mean_precision(detect, in_mm, THRESHOLDS_MM),
        ar_vsd,
        ar,
    )


def matches_in_mm(
    predictions: Sequence[PoseEstimate], images: Sequence[ImageRecord], models: ErrorModels, min_visible: float = 0.1
) -> dict[tuple[int, int], list[tuple[int, Matches]]]:
    """Return by object and threshold of MSSD (mm) the scene and the matches of each image, as ``ap_mssd_mm`` has them.

    Args:
        predictions: Estimates of all images.
        images: Images with their targets.
        models: Where errors are measured.
        min_visible: Fraction (0-1) that must be seen of what is to be found.
    """
    kept = _best_of_each_image(predictions)
    groups = group_by_object(kept, images)
    found: dict[tuple[int, int], list[tuple[int, Matches]]] = {}
    for group, errors in zip(groups, pairwise_errors(groups, kept, mssd_if_near(models), models), strict=True):
        wanted = _Wanted.of(group, kept, min_visible)
        for threshold in THRESHOLDS_MM:
            mine = found.setdefault((wanted.obj_id, threshold), [])
            mine.append((group.image.scene_id, _matches(wanted, 1000.0 * errors, threshold)))
    return {key: parts for key, parts in found.items() if any(item.wanted for _, item in parts)}


def match_by_score(
    errors: Float[np.ndarray, "p g"], scores: Float[np.ndarray, " p"], most: int, threshold: float
) -> dict[int, int]:
    """Match estimates, the highest score first, each with the ground truth that is nearest and still free.

    Args:
        errors: Of each estimate against each ground truth; inf where they cannot belong together.
        scores: Of each estimate.
        most: How many estimates are taken.
        threshold: Errors from here on are no match.

    Returns:
        Row of the ground truth by row of the estimate.
    """
    open_errors, found = errors.copy(), {}
    for row in np.argsort(-scores, kind="stable")[:most].tolist():
        nearest = int(open_errors[row].argmin()) if open_errors.shape[1] else -1
        if nearest >= 0 and open_errors[row, nearest] < threshold:
            found[row] = nearest
            open_errors[:, nearest] = np.inf
    return found


def _over_diameter(models: ErrorModels) -> ErrorOf:
    in_metres = mssd_if_near(models)

    def error_of(
        T_estimated: Transforms, targets: Sequence[TargetRecord], images: Sequence[ImageRecord]
    ) -> Float[np.ndarray, " n"]:
        return in_metres(T_estimated, targets, images) / models.info(targets[0]).diameter

    return error_of


def _over_width(models: ErrorModels) -> ErrorOf:
    def error_of(
        T_estimated: Transforms, targets: Sequence[TargetRecord], images: Sequence[ImageRecord]
    ) -> Float[np.ndarray, " n"]:
        K = np.stack([image.camera.K for image in images])
        T_gt = np.stack([target.T_camera_object for target in targets])
        symmetry, points = models.info(targets[0]).symmetry, models.points(targets[0]).surface
        widths = np.array([image.camera.width for image in images])
        return mspd(T_estimated, T_gt, symmetry, K, points) * (640.0 / widths) / 100.0

    return error_of


class _Wanted(NamedTuple):
    """What is to be found of a group, and how sure its estimates are."""

    obj_id: int
    evaluated: Bool[np.ndarray, " g"]
    scores: Float[np.ndarray, " p"]

    @classmethod
    def of(cls, group: Group, predictions: Sequence[PoseEstimate], min_visible: float) -> "_Wanted":
        """Return what counts from ``min_visible`` on."""
        evaluated = np.array([target.visible_fraction >= min_visible for target in group.targets])
        scores = np.array([predictions[row].score for row in group.estimates], dtype=float)
        return cls(group.targets[0].obj_id, evaluated, scores)


def _average_recall(groups: Sequence[_Wanted], ways: Sequence[Sequence[Float[np.ndarray, "p g"]]]) -> float:
    """Return the mean recall over all thresholds and over several ways to measure the errors of all groups."""
    wanted, hits = 0, 0
    for errors in ways:
        for (_, evaluated, scores), of_group in zip(groups, errors, strict=True):
            count = int(evaluated.sum())
            wanted += count
            for threshold in THRESHOLDS:
                hits += len(match_by_score(of_group[:, evaluated], scores, count, threshold))
    return hits / (wanted * len(THRESHOLDS)) if wanted else float("nan")


def _mean_precision(
    groups: Sequence[_Wanted], errors: Sequence[Float[np.ndarray, "p g"]], thresholds: Sequence[float]
) -> float:
    by_object: dict[int, list[tuple[_Wanted, np.ndarray]]] = {}
    for group, of_group in zip(groups, errors, strict=True):
        by_object.setdefault(group.obj_id, []).append((group, of_group))
    precisions = [
        average_precision([_matches(group, own, threshold) for group, own in parts])
        for parts in by_object.values()
        if any(group.evaluated.any() for group, _ in parts)
        for threshold in thresholds
    ]
    return float(np.mean(precisions)) if precisions else float("nan")


def _matches(group: _Wanted, errors: Float[np.ndarray, "p g"], threshold: float) -> Matches:
    _, evaluated, scores = group
    right, ignored = np.zeros((2, len(scores)), dtype=bool)
    for row, column in match_by_score(errors, scores, len(scores), threshold).items():
        right[row], ignored[row] = evaluated[column], not evaluated[column]
    order = np.argsort(-scores, kind="stable")
    return Matches(scores[order], right[order], ignored[order], int(evaluated.sum()))


def _best_of_each_image(predictions: Sequence[PoseEstimate]) -> list[PoseEstimate]:
    """Return the estimates in order, of each image no more than count for detection."""
    by_image: dict[tuple[int, int], list[int]] = {}
    for row, item in enumerate(predictions):
        by_image.setdefault((item.scene_id, item.image_id), []).append(row)
    kept: list[int] = []
    for rows in by_image.values():
        kept += sorted(rows, key=lambda row: -predictions[row].score)[:_MOST_IN_IMAGE]
    return [predictions[row] for row in sorted(kept)]
