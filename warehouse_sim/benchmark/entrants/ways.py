"""How tables use an estimator: ``NAME+WORD+...``, such as ``densefusion-depth+verify``.

Words are selections (argmax, weighted, weighted-50, consensus), refinements (icp, verification), ``flight`` for a
camera that measures time of flight, ``reject-blocked`` for rejecting estimates whose openings are blocked, ``lidar``
and ``lidar-sparse`` for the depth of a LiDAR, ``boxes`` for ground-truth boxes in place of ground-truth masks, and
``nominal`` for the calibration that the rig states. A trained estimator that names neither selection nor refinement
goes by consensus and ICP; one that names a selection alone is not refined.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import get_args

import numpy as np

from warehouse_sim.benchmark.disturbances import UNNAMED, disturbance
from warehouse_sim.benchmark.entrants.detected import SEEN, KeptFinder
from warehouse_sim.benchmark.kept import weights_digest
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import InputError, UnknownNameError
from warehouse_sim.estimators.api import Composition, Configurable, PoseEstimator
from warehouse_sim.estimators.detections import Finder
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pose.choose import Selection
from warehouse_sim.estimators.pose.icp.oracle import OracleIcp
from warehouse_sim.estimators.predict import require_known
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.estimators.settings import IMAGES_AT_ONCE, PredictConfig
from warehouse_sim.resources import data_folder, model_names
from warehouse_sim.schema import PoseEstimate
from warehouse_sim.version import __version__

_VERIFICATION = "verify"
_WORDS: dict[str, dict[str, object]] = {
    **{name: {"selection": name} for name in get_args(Selection)},
    "icp": {"refine": "icp"},
    _VERIFICATION: {"refine": "verify"},
    "flight": {"time_of_flight": True},
    "reject-blocked": {"reject_blocked": True},
    "lidar": {"depth": "lidar"},
    "lidar-sparse": {"depth": "lidar-sparse"},
    "boxes": {"detections": "gt-boxes"},
    "nominal": {"calibration": "nominal"},
}
_OF_TRAINED = ("selection", "refine", "time_of_flight", "reject_blocked")


@dataclass(frozen=True)
class Way:
    """An estimator and how it predicts."""

    model: str
    """Bundled model, run folder, or registered estimator that needs no training."""
    config: PredictConfig
    """Settings of prediction."""

    @property
    def folder(self) -> Path:
        """Where its weights, if any, and its uncertainty lie."""
        return Path(self.model) if Path(self.model).is_dir() else data_folder("models") / self.model

    @property
    def is_trained(self) -> bool:
        """Whether it has weights, or those behind it have."""
        return _has_stages(self.model)

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of all bundled models that it may be made of."""
        registered = ESTIMATORS.get(self.model) if self.model in ESTIMATORS.names() else None
        inner = f"{registered.front_end}+{registered.estimator}" if isinstance(registered, Composition) else ""
        return (self.model, *filter(None, inner.split("+")))

    def open(self, objects: Mapping[int, ObjectInfo], uncertainty: bool = True) -> PoseEstimator:
        """Return the estimator, shown the objects of a dataset where it learns them that way."""
        estimator = load_estimator(self.model, replace(self.config, uncertainty=uncertainty))
        estimator.onboard(objects)
        return estimator


def is_trained(model: str) -> bool:
    """Return whether a name is that of bundled weights, or a run folder."""
    return model in model_names() or Path(model).is_dir()


def way_of(method: str) -> Way:
    """Return what a method of a command line stands for.

    Raises:
        UnknownNameError: There is no such word.
        InputError: Verification or ICP is requested beside an estimator that goes by nothing else.
    """
    if Path(method).is_dir():
        return Way(method, PredictConfig(selection="consensus", refine="icp"))
    model, *words = method.split("+")
    options: dict[str, object] = {}
    for word in words:
        if word not in _WORDS:
            raise UnknownNameError(f"word of {method!r}", word, list(_WORDS))
        options |= _WORDS[word]
    if not _has_stages(model):
        if beside := [word for word in words if set(_WORDS[word]) & set(_OF_TRAINED)]:
            raise InputError(f"{model} needs no training and decides by verification itself: leave +{beside[0]} out")
        return Way(model, replace(PredictConfig().without_stages(), **options))  # type: ignore[arg-type]
    default = PredictConfig(selection="consensus", refine="none" if "selection" in options else "icp")
    return Way(model, replace(default, **options))  # type: ignore[arg-type]


def _has_stages(model: str) -> bool:
    """Return whether selection and refinement are to be chosen: of networks, alone or behind a front end."""
    if is_trained(model) or model not in ESTIMATORS.names():
        return is_trained(model)
    registered = ESTIMATORS.get(model)
    behind = registered.estimator if isinstance(registered, Composition) else ""
    return isinstance(registered, Configurable) and (not behind or is_trained(behind))


def answers(
    way: Way,
    reader: DatasetReader,
    split: str,
    disturb: str,
    progress: Callable[[float, str], None],
    kept: Path | None = None,
) -> list[PoseEstimate]:
    """Return the estimates of a split's images, in their order.

    Where nobody names the object, those of the dataset that the estimator knows are what it may be. Times count the
    detection, as those of ``predict`` do; who states none is timed.

    Args:
        way: The estimator and its settings.
        reader: The dataset.
        split: Which images.
        disturb: Name of what is done to each image; it has a random stream of its own.
        progress: Called with the fraction that is done.
        kept: Where what detectors find is kept; None keeps nothing.

    Raises:
        UnknownNameError: No such estimator or disturbance.
        TrainingError: There are no weights, or they know no object of the split.
    """
    change, (estimator, finder, reader) = disturbance(disturb), opened(way, reader, split, kept)
    images = reader.images(split)
    may_be = _candidates(estimator, reader) if disturb == UNNAMED else ()
    found: list[PoseEstimate] = []
    for start in range(0, len(images), IMAGES_AT_ONCE):
        group = images[start : start + IMAGES_AT_ONCE]
        seen, seconds = list[RgbdImage](), dict[tuple[int, int], float]()
        for record in group:
            if (image := finder.find(estimator, reader, record)) is None:
                continue
            rng = np.random.default_rng([image.scene_id, image.image_id])
            seen.append(_as_one_of(change(image, rng), may_be))
            seconds[image.scene_id, image.image_id] = finder.seconds
        found += [_with_time(item, seconds) for item in _estimated(estimator, seen)]
        progress((start + len(group)) / len(images), f"{len(found)} poses")
    return found


def opened(
    way: Way, reader: DatasetReader, split: str, kept: Path | None
) -> tuple[PoseEstimator, Finder, DatasetReader]:
    """Return an estimator that knows the objects of a split, what finds detections for it, and whom both read.

    Args:
        way: The estimator and its settings.
        reader: The dataset.
        split: Which images.
        kept: Where what detectors find is kept; None keeps nothing.

    Raises:
        UnknownNameError: No such estimator.
        TrainingError: There are no weights, or they know no object of the split.
    """
    config = way.config
    if config.calibration != reader.calibration:
        reader = DatasetReader(reader.root, config.calibration)
    estimator, images = way.open(reader.objects), reader.images(split)
    if isinstance(estimator, OracleIcp):
        estimator.show(images)
    require_known(estimator, reader, images)
    inputs = {
        "weights_sha256": {Path(name).name: weights_digest(name) for name in config.detections.split("+")},
        "data": reader.digest,
        "calibration": reader.calibration,
        "gravity": config.gravity,
        "version": __version__,
    }
    folder = None if kept is None else kept / SEEN / reader.root.resolve().name
    return estimator, KeptFinder(config, inputs, folder), reader


def _estimated(estimator: PoseEstimator, images: list[RgbdImage]) -> list[PoseEstimate]:
    """Return the estimates of some images; one that states no time gets the mean of what all of them took."""
    if not images:
        return []
    started = time.perf_counter()
    found = estimator.estimate_all(images)
    each = (time.perf_counter() - started) / len(images)
    return [item if item.time >= 0.0 else replace(item, time=each) for item in found]


def _with_time(item: PoseEstimate, seconds: dict[tuple[int, int], float]) -> PoseEstimate:
    return replace(item, time=item.time + seconds[item.scene_id, item.image_id]) if item.time >= 0 else item


def _candidates(estimator: PoseEstimator, reader: DatasetReader) -> tuple[int, ...]:
    if estimator.objects is None:
        return ()
    return tuple(sorted({shape.obj_id for shape in estimator.objects} & set(reader.objects)))


def _as_one_of(image: RgbdImage, may_be: tuple[int, ...]) -> RgbdImage:
    if not may_be:
        return image
    return replace(image, detections=tuple(replace(item, may_be=may_be) for item in image.detections))
