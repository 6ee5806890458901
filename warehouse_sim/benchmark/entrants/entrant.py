"""Who enters a suite: the oracle, shuffled ground truth, estimators by name or run folder, result files."""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from warehouse_sim.benchmark.entrants.subset import subset_answers
from warehouse_sim.benchmark.entrants.ways import Way, answers, way_of
from warehouse_sim.benchmark.kept import file_digest, weights_digest
from warehouse_sim.benchmark.suite import ConditionConfig
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.dataset.results import predictions
from warehouse_sim.errors import InputError, UnknownNameError
from warehouse_sim.estimators.detections import GT
from warehouse_sim.estimators.own.program import PROGRAM, words_of
from warehouse_sim.estimators.own.source import is_own_source
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.resources import model_names
from warehouse_sim.schema import PoseEstimate
from warehouse_sim.version import __version__

ORACLE, SHUFFLED, CEILING = "oracle", "shuffled", "oracle-icp"
LADDER = (SHUFFLED, "rectangle-fit", "icp-multistart", CEILING, ORACLE)
"""References of every table, from chance to ground truth; methods stand before the ceiling of the sensor."""
Fraction = Callable[[float, str], None]
_SEED = 20_260
"""Of the shuffling."""
_WHO = "estimator (a bundled name, a run folder, one that needs no training, or a CSV of poses)"
_TRIES = 100
"""Draws before all others are gone through."""


@dataclass(frozen=True, eq=False)
class Request:
    """What an entrant answers: the images of a split."""

    reader: DatasetReader
    split: str
    condition: ConditionConfig
    """What is evaluated."""
    progress: Fraction
    """Called with the fraction that is done."""
    kept: Path | None = None
    """Where what detectors find is kept; None keeps nothing."""


class Entrant(Protocol):
    """Who answers."""

    @property
    def name(self) -> str:
        """As tables call it."""

    @property
    def trainings(self) -> int:
        """How many trainings are behind a number: 0 where nothing is trained."""

    def inputs(self, condition: ConditionConfig) -> dict[str, Any]:
        """Return all that decides its answers besides the data."""

    def estimates(self, request: Request) -> list[PoseEstimate]:
        """Return its answers."""


@dataclass(frozen=True)
class Oracle:
    """The labels themselves: what a metric gives to whoever is right."""

    name: str = ORACLE
    trainings: int = 0

    def inputs(self, condition: ConditionConfig) -> dict[str, Any]:
        """Return its name: the data decide the rest."""
        return {"kind": ORACLE}

    def estimates(self, request: Request) -> list[PoseEstimate]:
        """Return every label as an estimate."""
        return [_estimate(image, item, item.T_camera_object) for image, item in _labels(request)]


@dataclass(frozen=True)
class Shuffled:
    """Each label's pose given to another object of its class, seen from elsewhere: what chance scores."""

    name: str = SHUFFLED
    trainings: int = 0

    def inputs(self, condition: ConditionConfig) -> dict[str, Any]:
        """Return its name and the seed."""
        return {"kind": SHUFFLED, "seed": _SEED}

    def estimates(self, request: Request) -> list[PoseEstimate]:
        """Return every label with the pose of one in another place; of a dataset with one image nothing is left."""
        labels = _labels(request)
        rng = np.random.default_rng(_SEED)
        by_object: dict[int, list[tuple[ImageRecord, TargetRecord]]] = defaultdict(list)
        for image, item in labels:
            by_object[item.obj_id].append((image, item))
        found, taken = [], set[tuple[int, int, bytes]]()
        for image, item in labels:
            among = by_object[item.obj_id], labels
            sampled = (_rendered_elsewhere(image, some, rng, taken) for some in among)
            other = next((one for one in sampled if one is not None), None)
            if other is not None:
                taken.add((image.scene_id, image.image_id, other.T_camera_object.tobytes()))
                found.append(_estimate(image, item, other.T_camera_object))
        return found


@dataclass(frozen=True)
class Evaluated:
    """An estimator of this package or of a plug-in, or the trainings of one with several seeds: one of them."""

    name: str
    way: Way
    trainings: int = 0

    def inputs(self, condition: ConditionConfig) -> dict[str, Any]:
        """Return its weights by their hash, its settings, and what is done to what it sees."""
        config = self.config_under(condition)
        names = [*self.way.parts, *config.detections.split("+")]
        limit = condition.seconds_an_object
        return {
            "kind": "estimator",
            "model": self.way.model if not Path(self.way.model).is_dir() else "run folder",
            "weights_sha256": {Path(name).name: found for name in names if (found := weights_digest(name))},
            "predict": to_mapping(config),
            "disturb": condition.disturb,
            "version": __version__,
            **({} if limit is None else {"seconds_an_object": limit}),
        }

    def config_under(self, condition: ConditionConfig) -> PredictConfig:
        """Return its settings of prediction under a condition.

        Raises:
            ConfigError: The condition sets what is no setting of prediction.
        """
        plain = to_mapping(self.way.config) | condition.predict
        if self.way.model == CEILING:
            plain["detections"] = GT  # whatever others find: it reads the labels
        return from_mapping(PredictConfig, plain, f"conditions: {condition.data}: predict")

    def estimates(self, request: Request) -> list[PoseEstimate]:
        """Return what the estimator says."""
        reader, split, condition = request.reader, request.split, request.condition
        way = replace(self.way, config=self.config_under(condition))
        if condition.seconds_an_object is not None:
            return subset_answers(way, reader, split, condition.seconds_an_object, request.progress, request.kept)
        return answers(way, reader, split, condition.disturb, request.progress, request.kept)


@dataclass(frozen=True)
class ResultFile:
    """Third-party poses: one CSV, or a folder with one for each condition or dataset by its name."""

    name: str
    path: Path
    trainings: int = 0

    def inputs(self, condition: ConditionConfig) -> dict[str, Any]:
        """Return the hash of the file."""
        return {"kind": "file", "sha256": file_digest(self._file(condition))}

    def estimates(self, request: Request) -> list[PoseEstimate]:
        """Return the rows of the file."""
        return predictions.read(self._file(request.condition))

    def _file(self, condition: ConditionConfig) -> Path:
        file = self.path if self.path.suffix == ".csv" else self.path / f"{condition.data}.csv"
        if not file.is_file():
            raise InputError(f"{file}: there is no such file; a folder of results has one CSV for each dataset's name")
        return file


@dataclass(frozen=True)
class Group:
    """One row of a table: an entrant, or several trainings of one."""

    name: str
    members: tuple[Entrant, ...]
    facts: Mapping[str, Any] = field(default_factory=dict)
    """What else a result says of it."""

    @property
    def trainings(self) -> int:
        """How many trainings are behind its numbers; 0 where nothing is trained."""
        return sum(item.trainings for item in self.members)


def entrant(name: str) -> Group:
    """Return what a name stands for: oracle, shuffled, a CSV or a folder of such, or an estimator's way.

    Raises:
        UnknownNameError: Nobody does.
        InputError: It gets an option that it does not take.
    """
    if name in (ORACLE, SHUFFLED):
        return Group(name, (Oracle() if name == ORACLE else Shuffled(),))
    path = Path(name)
    if path.suffix == ".csv" or (path.is_dir() and not (path / "config.yaml").is_file() and any(path.glob("*.csv"))):
        return Group(path.stem, (ResultFile(path.stem, path),))
    if name.startswith(PROGRAM):
        words_of(name.removeprefix(PROGRAM))  # what is no command is rejected before anything is made
        return Group(name, (Evaluated(name, Way(name, PredictConfig())),))
    if is_own_source(name):
        shown = path.name  # results name no folder of this machine
        return Group(shown, (Evaluated(shown, Way(name, PredictConfig())),))
    way = way_of(name)
    known = {*model_names(), *ESTIMATORS.names()}
    if way.model not in known and not Path(way.model).is_dir():
        raise UnknownNameError(_WHO, name, [ORACLE, SHUFFLED, *known])
    shown = path.name if path.is_dir() else name
    return Group(shown, (Evaluated(shown, way, trainings=int(way.is_trained)),))


def _labels(request: Request) -> list[tuple[ImageRecord, TargetRecord]]:
    images = request.reader.images(request.split)
    return [(image, item) for image in images for item in image.targets if item.has_pose]


def _estimate(image: ImageRecord, item: TargetRecord, T_camera_object: np.ndarray) -> PoseEstimate:
    return PoseEstimate(image.scene_id, image.image_id, item.obj_id, 1.0, T_camera_object, detection=item.gt_index)


def _rendered_elsewhere(
    image: ImageRecord,
    among: Sequence[tuple[ImageRecord, TargetRecord]],
    rng: np.random.Generator,
    taken: set[tuple[int, int, bytes]],
) -> TargetRecord | None:
    """Return a target of another place whose pose no other of the image has got."""

    def is_free(other: ImageRecord, item: TargetRecord) -> bool:
        return (
            _elsewhere(image, other) and (image.scene_id, image.image_id, item.T_camera_object.tobytes()) not in taken
        )

    for _ in range(_TRIES):
        other, item = among[int(rng.integers(len(among)))]
        if is_free(other, item):
            return item
    return next((item for other, item in among if is_free(other, item)), None)


def _elsewhere(image: ImageRecord, other: ImageRecord) -> bool:
    """Return whether an image was taken in another scene or from another place; paired variants share poses."""
    if other.scene_id != image.scene_id:
        return True
    # Where a dataset says nothing of a world, all images have that of the camera.
    unknown = np.array_equal(image.T_world_camera, np.eye(4))
    return other.image_id != image.image_id and (unknown or not np.allclose(other.T_world_camera, image.T_world_camera))
