"""The predictions that are scored, a file or estimates in memory, and whether they fit the ground truth."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.object_gt import geometry_problems
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, ObjectInfo, TargetRecord
from warehouse_sim.dataset.results import predictions as prediction_file
from warehouse_sim.dataset.results.pose_csv import require_estimates
from warehouse_sim.errors import EvaluationError
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.schema import PoseEstimate


@dataclass(frozen=True, eq=False)
class ScoredEstimates:
    """Estimates, and how messages name them."""

    estimates: tuple[PoseEstimate, ...]
    """Those that are not rejected."""
    rejected: int
    """How many are."""
    name: str
    """The file, or what stands for it."""
    method: str
    """What predicted, as it is stated beside the file, or else the file's name up to the first underscore (the BOP
    rule)."""
    is_file: bool
    predicted_by: str = ""
    """The command that predicted, where that is stated."""

    @classmethod
    def of(cls, predictions: str | Path | Sequence[PoseEstimate]) -> "ScoredEstimates":
        """Read a file of predictions, or take estimates.

        Raises:
            DatasetError: The file cannot be read.
            InputError: Something in the list is no estimate.
        """
        if isinstance(predictions, (str, Path)):
            path = Path(predictions)
            found = tuple(prediction_file.read(path))
            origin = prediction_file.origin(path)
            method, command = (path.stem.split("_")[0], "") if origin is None else (origin.method, origin.command)
            return cls(found, prediction_file.count_rejected(path), str(path), method, True, command)
        estimates = require_estimates(predictions, "the predictions")
        kept = tuple(item for item in estimates if not item.rejected)
        return cls(kept, len(estimates) - len(kept), "the estimates", "estimates", False)

    def place(self, number: int) -> str:
        """Return how messages name one estimate by its position."""
        return f"{self.name}: line {number + 2}" if self.is_file else f"estimate {number}"

    def seconds_per_image(self) -> float | None:
        """Return the mean time of the estimator, where the predictions hold it."""
        times = {(item.scene_id, item.image_id): item.time for item in self.estimates if item.time >= 0.0}
        return round(float(np.mean(list(times.values()))), 6) if times else None

    def check(self, images: Sequence[ImageRecord], split: str, reader: DatasetReader) -> None:
        """Reject what cannot be scored: strange images and objects, another unit or frame.

        Args:
            images: Of the split.
            split: Its name, for messages.
            reader: The dataset.

        Raises:
            EvaluationError: An estimate does not fit the split, or the dataset contradicts itself.
        """
        _check_places(self, images, set(reader.objects), f"split {split!r} of {reader.root}")
        check_unit(self.estimates, images, self.name)
        _check_geometry(images, reader.objects, reader.root)
        _check_in_front(self, reader.objects)


def require_scorable(images: Sequence[ImageRecord], split: str, data: Path) -> None:
    """Reject a split without poses, and one whose images estimates cannot tell apart by scene and image.

    Raises:
        EvaluationError: It is such a split.
    """
    if images and not any(target.has_pose for image in images for target in image.targets):
        masks = sum(len(image.targets) for image in images)
        raise EvaluationError(
            f"{data}: split {split!r} has no poses to score against: {len(images)} images, {masks} bare masks; "
            "predict and inspect take it, evaluate needs labels such as those of a BOP folder"
        )
    twice = [place for place, count in Counter((item.scene_id, item.image_id) for item in images).items() if count > 1]
    if twice:
        raise EvaluationError(
            f"{data}: scene {twice[0][0]} image {twice[0][1]} is in several splits of {split!r}; score one split"
        )


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


def _check_places(given: ScoredEstimates, images: Sequence[ImageRecord], objects: set[int], where: str) -> None:
    known = {(image.scene_id, image.image_id) for image in images}
    for number, estimate in enumerate(given.estimates):
        if (estimate.scene_id, estimate.image_id) not in known:
            raise EvaluationError(
                f"{given.place(number)}: scene {estimate.scene_id} image {estimate.image_id} is not in {where}; "
                "check --split and --data"
            )
        if estimate.obj_id not in objects:
            raise EvaluationError(f"{given.place(number)}: object {estimate.obj_id} is not in {where}; check --data")


def _check_geometry(images: Sequence[ImageRecord], objects: Mapping[int, ObjectInfo], data: Path) -> None:
    """Reject scores by an object's numbers that its own mesh contradicts, and by a ground truth that no camera sees."""
    labelled, path = {target.obj_id for image in images for target in image.targets}, DatasetLayout(data).objects
    if labelled - set(objects):
        raise EvaluationError(
            f"{path}: lacks the labelled objects {sorted(labelled - set(objects))}; "
            "run warehouse-sim validate on the dataset"
        )
    for obj_id in sorted(labelled):
        problems = geometry_problems(objects[obj_id])
        if problems:
            raise EvaluationError(f"{path}: {obj_id}: {problems[0]}; run warehouse-sim validate on the dataset")
    for image in images:
        for target in image.targets:
            T, info = target.T_camera_object, target.info(objects)
            around = bool(np.all(np.abs(invert(T)[:3, 3]) < info.size / 2.0))
            if around or _behind(T, info):
                raise EvaluationError(
                    f"{data}: scene_gt.json of {image.split} scene {image.scene_id}: image {image.image_id}: "
                    f"target {target.gt_index} is {'around' if around else 'behind'} the camera; "
                    "run warehouse-sim validate on the dataset"
                )


def _check_in_front(given: ScoredEstimates, objects: Mapping[int, ObjectInfo]) -> None:
    """Reject predictions that all lie behind the camera: they are in another frame."""
    if given.estimates and all(_behind(item.T_camera_object, objects[item.obj_id]) for item in given.estimates):
        raise EvaluationError(
            f"{given.name}: every estimate is behind the camera; poses have z forward, in the frame of OpenCV"
        )


def _behind(T_camera_object: Transform, info: ObjectInfo) -> bool:
    """Say whether no corner of the object's box has z > 0; the centre of a near object can lie beside the camera."""
    return bool(T_camera_object[2, 3] + np.abs(T_camera_object[2, :3]) @ info.size / 2.0 <= 0.0)
