"""Which estimate answers for which ground truth: the rules of the BOP localisation task, over all images of a split."""

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.dataset.reader import ImageRecord, TargetRecord
from warehouse_sim.evaluation.errors.pose_error import estimates_in_object, mssd
from warehouse_sim.evaluation.errors.surface import ErrorModels
from warehouse_sim.geometry.pose import Transforms
from warehouse_sim.schema import PoseEstimate

Place = tuple[int, int, int]
"""Scene id, image id, instance id."""


def match(
    errors: Float[np.ndarray, "p g"], scores: Float[np.ndarray, " p"], counted: Bool[np.ndarray, " g"]
) -> Int[np.ndarray, " g"]:
    """Assign estimates of one object class in one image to its ground truths.

    An estimate nearest to a ground truth that does not count (one that is hardly visible) answers for that one and is
    set aside, as in the BOP 2024 detection task. Of the rest, as many as there are counted ground truths are kept, the
    highest scores first (BOP 2019 localisation); surplus guesses cannot help. The kept ones are matched greedily, the
    smallest error first, each used once.

    Args:
        errors: Error of each estimate against each ground truth; inf where they cannot belong together.
        scores: Confidence of each estimate.
        counted: Which ground truths enter the score.

    Returns:
        For each ground truth the row of its estimate, -1 where it has none.
    """
    # Most groups are of a few: lists are quicker than arrays.
    rows, is_counted = errors.tolist(), counted.tolist()
    matched = [-1] * len(is_counted)
    candidates = []
    for number, row in enumerate(rows):
        least = min(row, default=math.inf)
        if least == math.inf or is_counted[row.index(least)]:
            candidates.append(number)
    worth = scores.tolist()
    candidates.sort(key=lambda number: -worth[number])
    kept = candidates[: sum(is_counted)]
    possible = sorted(
        (error, number, column)
        for number in kept
        for column, error in enumerate(rows[number])
        if is_counted[column] and error < math.inf
    )
    taken = set[int]()
    for _, number, column in possible:
        if number not in taken and matched[column] < 0:
            matched[column] = number
            taken.add(number)
    return np.array(matched, dtype=int)


_AT_ONCE = 50_000
"""Pairs whose errors are measured at once, which bounds memory."""


@dataclass(frozen=True, eq=False)
class Pair:
    """A ground truth that counts, with its estimate if it has one."""

    image: ImageRecord
    target: TargetRecord
    prediction: int
    """Row among the predictions, -1 for a miss."""

    @property
    def place(self) -> Place:
        """Return which object of which image the ground truth is."""
        return self.image.scene_id, self.image.image_id, self.target.instance_id


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
        min_visible_fraction: Visible fraction (0-1) from which a ground truth counts.

    Returns:
        One pair a ground truth that counts.
    """
    groups = group_by_object(predictions, images)
    pairs = []
    for group, errors in zip(groups, pairwise_errors(groups, predictions, mssd_if_near(models), models), strict=True):
        counted = np.array(
            [target.visible_fraction >= min_visible_fraction and models.counts(target) for target in group.targets]
        )
        matched = match(errors, np.array([predictions[index].score for index in group.estimates]), counted)
        for target, row, counts in zip(group.targets, matched.tolist(), counted.tolist(), strict=True):
            if counts:
                pairs.append(Pair(group.image, target, group.estimates[row] if row >= 0 else -1))
    return pairs


@dataclass(frozen=True, eq=False)
class Group:
    """What can belong together: the objects of one kind in an image, and the estimates of them."""

    image: ImageRecord
    targets: Sequence[TargetRecord]
    estimates: Sequence[int]
    """Rows of the predictions."""


ErrorOf = Callable[[Transforms, Sequence[TargetRecord], Sequence[ImageRecord]], Float[np.ndarray, " n"]]
"""From estimates, "n 4 4", with targets of one model and their images, to the error of each."""


def group_by_object(predictions: Sequence[PoseEstimate], images: Sequence[ImageRecord]) -> list[Group]:
    """Return the groups of all images, by image and object; estimates of what an image lacks are in none."""
    by_place: dict[tuple[int, int, int], list[int]] = defaultdict(list)
    for index, prediction in enumerate(predictions):
        by_place[prediction.scene_id, prediction.image_id, prediction.obj_id].append(index)
    groups = []
    for image in images:
        alike: dict[int, list[TargetRecord]] = defaultdict(list)
        for target in image.targets:
            alike[target.obj_id].append(target)
        for obj_id in sorted(alike):
            groups.append(Group(image, alike[obj_id], by_place.get((image.scene_id, image.image_id, obj_id), [])))
    return groups


def pairwise_errors(
    groups: Sequence[Group], predictions: Sequence[PoseEstimate], error_of: ErrorOf, models: ErrorModels
) -> list[Float[np.ndarray, "p g"]]:
    """Return for each group the error of each estimate against each ground truth: all those of one model at once."""
    errors = [np.full((len(group.estimates), len(group.targets)), np.inf) for group in groups]
    places: dict[int, list[tuple[int, int, int]]] = defaultdict(list)
    for number, group in enumerate(groups):
        for column, target in enumerate(group.targets):
            mine = places[id(models.info(target))]
            mine += [(number, row, column) for row in range(len(group.estimates))]
    for mine in places.values():
        for first in range(0, len(mine), _AT_ONCE):
            part = mine[first : first + _AT_ONCE]
            targets = [groups[number].targets[column] for number, _, column in part]
            estimated = np.concatenate([predictions[groups[i].estimates[row]].T_camera_object for i, row, _ in part])
            found = error_of(estimated.reshape(-1, 4, 4), targets, [groups[number].image for number, _, _ in part])
            for (number, row, column), error in zip(part, found.tolist(), strict=True):
                errors[number][row, column] = error
    return errors


def mssd_if_near(models: ErrorModels) -> ErrorOf:
    """Return what measures MSSD (m); inf where the centre is a diameter away: another object, as in BOP's scripts."""

    def error_of(
        T_estimated: Transforms, targets: Sequence[TargetRecord], _: Sequence[ImageRecord]
    ) -> Float[np.ndarray, " n"]:
        info, points = models.info(targets[0]), models.points(targets[0])
        T_gt = np.concatenate([target.T_camera_object for target in targets]).reshape(-1, 4, 4)
        errors = mssd(estimates_in_object(T_estimated, T_gt, info.symmetry), points.hull).min(axis=-1)
        distance = np.linalg.norm(T_estimated[:, :3, 3] - T_gt[:, :3, 3], axis=-1)
        return np.where(distance < info.diameter, errors, np.inf)

    return error_of
