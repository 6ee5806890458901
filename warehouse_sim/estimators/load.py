"""Open an estimator: bundled weights, a run folder, one that needs no training, a composed one, or a user's own."""

from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.errors import InputError, TrainingError, UnknownNameError
from warehouse_sim.estimators.api import Composition, Configurable, PoseEstimator
from warehouse_sim.estimators.detections import open_stages
from warehouse_sim.estimators.own.estimator import OwnEstimator, own_estimator
from warehouse_sim.estimators.own.program import PROGRAM, ProgramEstimator
from warehouse_sim.estimators.own.source import is_own_source, open_source
from warehouse_sim.estimators.pipeline import WithFrontEnd
from warehouse_sim.estimators.pose.densefusion.objects import MESHES, read_meshes
from warehouse_sim.estimators.pose.uncertainty.estimator import WithUncertainty
from warehouse_sim.estimators.pose.uncertainty.model import read_uncertainty
from warehouse_sim.estimators.registries import ESTIMATORS, FAMILIES, FRONT_ENDS, is_trainable
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.learning.run_folder import read_kind
from warehouse_sim.resources import data_folder, model_dir, model_names

_WHO = "estimator (a bundled name or a run folder, one that is not trained, file.py:Class or module:Class)"


def load_estimator(
    source: str | Path | object,
    config: PredictConfig = PredictConfig(),  # noqa: B008  frozen
) -> PoseEstimator:
    """Return a bundled estimator by name ("densefusion-pointcloud"), a trained one by its run folder, or another's.

    Args:
        source: Which one: a run folder, a bundled name, a registered one that needs no training, "file.py:Class",
            "module:Class", an object with ``estimate(image)``, or a function that takes an ``RgbdImage`` and returns a
            list of ``PoseEstimate``.
        config: How poses are selected and refined.

    Raises:
        UnknownNameError: None of these.
        TrainingError: The folder holds no complete run, or what is registered must be trained first.
        InputError: The estimator has no stages that ``config`` could choose, cannot reject or be tracked; or a user's
            own one cannot be opened.
    """
    if not isinstance(source, (str, Path)):
        return _own(own_estimator(source), config)
    name = str(source)
    if Path(name).is_dir() or name in model_names():
        return _of_folder(name, model_dir(source), config)
    registered = ESTIMATORS.names()
    if name not in registered:
        if name.startswith(PROGRAM):
            return _own(ProgramEstimator(name.removeprefix(PROGRAM)), config)
        if is_own_source(name):
            return _own(open_source(name), config)
        known = sorted({*model_names(), *registered})
        raise UnknownNameError(_WHO, name, known)
    target = ESTIMATORS.get(name)
    if is_trainable(target):
        raise TrainingError(f"{name} has no bundled weights: train it first, and predict with the run folder")
    if isinstance(target, Configurable):
        return own_estimator(target.configured(config), name)
    _require_own_way(name, config)
    made = own_estimator(target if isinstance(target, type) else target(), name)
    return _with_uncertainty(made, name, data_folder("models") / name, config.without_stages())


def _of_folder(name: str, folder: Path, config: PredictConfig) -> PoseEstimator:
    if (kind := read_kind(folder)) in FRONT_ENDS.names():
        raise InputError(f"{name} is a {kind}, which gives no poses; name it under --detections, or detect with it")
    if config.time_of_flight and config.refine == "none":
        raise InputError("--time-of-flight changes ICP and verification only: choose --refine icp or verify")
    estimator = own_estimator(FAMILIES.get(kind)(folder, config), name)
    return _with_uncertainty(estimator, name, folder, estimator.stages_used or config.with_stages())


def _own(estimator: PoseEstimator, config: PredictConfig) -> PoseEstimator:
    """Return a user's estimator.

    Raises:
        InputError: ``config`` holds settings that change nothing of it.
    """
    if isinstance(estimator, (OwnEstimator, ProgramEstimator)):
        _require_own_way(estimator.__name__, config)
        if config.reject is not None or config.reject_blocked:
            raise InputError(
                f"{estimator.__name__} has no fitted uncertainty to reject by; leave --reject and --reject-blocked out"
            )
    return estimator


def _require_own_way(name: str, config: PredictConfig) -> None:
    """Check that no option is given that only changes networks.

    Raises:
        InputError: Names the option.
    """
    given = {
        "--selection": config.selection not in (None, "argmax"),
        "--refine": config.refine not in (None, "none"),
        "--refiner-iterations": config.refiner_iterations is not None,
        "--time-of-flight": config.time_of_flight,
    }
    if useless := [option for option, is_given in given.items() if is_given]:
        raise InputError(f"{name} selects and refines in its own way; leave {' and '.join(useless)} out")


def _with_uncertainty(estimator: PoseEstimator, name: str, folder: Path, config: PredictConfig) -> PoseEstimator:
    """Return an estimator that says what it thinks of its poses, where that was fitted for these settings."""
    model = read_uncertainty(folder).get(*config.way) if config.uncertainty else None
    if model is not None:
        meshes = read_meshes(folder) if (folder / MESHES).is_file() else None
        return WithUncertainty(estimator, model, meshes, config.reject, config.seed, config.reject_blocked)
    if config.reject is not None or config.reject_blocked:
        selection, refine = config.way
        raise InputError(
            f"{name} cannot reject: no uncertainty was fitted for --selection {selection} --refine {refine}; "
            "leave --reject out, and --reject-blocked, or choose settings that uncertainty.yaml of its folder names"
        )
    if config.track and not isinstance(estimator, OwnEstimator):
        raise InputError(
            f"{name} cannot be tracked: its estimates have no covariance with these settings; leave --track out, or "
            "take an estimator and settings that docs/tracking.md names"
        )
    return estimator


@dataclass(frozen=True)
class Composed(Composition):
    """What a name of ``ESTIMATORS`` stands for when it is a front end and an estimator, both by name."""

    front_end: str
    """Detectors and segmenters joined by +."""
    estimator: str
    """Estimates poses of what they find."""

    @property
    def inputs(self) -> str:
        """What it is made of."""
        return f"{self.front_end}, then {self.estimator}"

    def configured(self, config: PredictConfig) -> PoseEstimator:
        """Return the estimator.

        Raises:
            TrainingError: The front end or the estimator has no bundled weights.
            InputError: The estimator has no stages that ``config`` could choose, or cannot reject.
        """
        return WithFrontEnd(load_estimator(self.estimator, config), open_stages(self.front_end), config.objects)


@dataclass(frozen=True)
class Keypoints(Composition):
    """What ``detect-keypoints`` stands for: boxes of a detector, key points in them, perspective-n-point."""

    front_end: str
    network: str
    """Bundled network of key points."""
    estimator = ""

    @property
    def inputs(self) -> str:
        """What it is made of."""
        return f"{self.front_end}, then {self.network} and PnP"

    def configured(self, config: PredictConfig) -> PoseEstimator:
        """Return the estimator.

        Raises:
            TrainingError: The front end or the network has no bundled weights.
        """
        if self.network not in model_names():
            raise TrainingError(f"{self.network} has no bundled weights: train it, and predict with its run folder")
        from warehouse_sim.estimators.pose.keypoints import KeypointEstimator

        return WithFrontEnd(KeypointEstimator(model_dir(self.network)), open_stages(self.front_end), config.objects)


RECOMMENDED = Composed(
    "detector-depth-warehouses+segmenter-depth-warehouses+segmenter-rgb-warehouses", "densefusion-depth-warehouses"
)
"""From pixels to poses in any layout."""
DETECT_KEYPOINTS = Keypoints("detector-rgb", "keypoints-rgb")
DETECT_DENSEFUSION = Composed("detector-rgb+cluster", "densefusion")
DETECT_DEPTH = Composed("detector-depth+cluster", "densefusion-depth")
_SEGMENT = "detector-depth+segmenter-depth"
SEGMENT_DENSEFUSION = Composed(_SEGMENT, "densefusion")
SEGMENT_DENSEFUSION_EARLY = Composed(_SEGMENT, "densefusion-early")
SEGMENT_DENSEFUSION_MIDDLE_1 = Composed(_SEGMENT, "densefusion-middle-1")
SEGMENT_DENSEFUSION_MIDDLE_2 = Composed(_SEGMENT, "densefusion-middle-2")
SEGMENT_DENSEFUSION_DEPTH = Composed(_SEGMENT, "densefusion-depth")
SEGMENT_DENSEFUSION_POINTCLOUD = Composed(_SEGMENT, "densefusion-pointcloud")
SEGMENT_OBJECT_COORDINATES = Composed(_SEGMENT, "object-coordinates")
SEGMENT_RECTANGLE_FIT = Composed(_SEGMENT, "rectangle-fit")
SEGMENT_ICP_MULTISTART = Composed(_SEGMENT, "icp-multistart")
SEGMENT_FRONT_FIT = Composed(_SEGMENT, "front-fit")
