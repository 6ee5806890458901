"""Open an estimator by name: bundled weights, a run folder, or one that needs no training."""

from pathlib import Path

from warehouse_sim.errors import InputError, TrainingError, UnknownNameError
from warehouse_sim.estimators import ESTIMATORS, FAMILIES, FRONT_ENDS, Configurable, PoseEstimator, is_trainable
from warehouse_sim.estimators.pose.densefusion.object_meshes import MESHES, read_meshes
from warehouse_sim.estimators.pose.uncertainty.estimator import WithUncertainty
from warehouse_sim.estimators.pose.uncertainty.model import read_uncertainty
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.learning.run_folder import read_kind
from warehouse_sim.resources import data_folder, model_dir, model_names


def load_estimator(name_or_run: str | Path, config: PredictConfig = PredictConfig()) -> PoseEstimator:  # noqa: B008  frozen
    """Return a bundled estimator by name ("densefusion-pointcloud"), a trained one by its run folder, or another's.

    Args:
        name_or_run: Which one: a run folder, a bundled name, or a registered one that needs no training.
        config: How poses are selected and refined.

    Raises:
        UnknownNameError: None of these.
        TrainingError: The folder holds no complete run, or what is registered must be trained first.
        InputError: The estimator has no stages that ``config`` could choose, or cannot reject.
    """
    name = str(name_or_run)
    if Path(name_or_run).is_dir() or name in model_names():
        folder = model_dir(name_or_run)
        if (kind := read_kind(folder)) in FRONT_ENDS.names():
            raise InputError(f"{name} is a {kind}, which gives no poses; name it under --detections, or detect with it")
        if config.time_of_flight and config.refine == "none":
            raise InputError("--time-of-flight tells ICP and verification what to believe: add --refine icp or verify")
        estimator: PoseEstimator = FAMILIES.get(read_kind(folder))(folder, config)
        return _with_uncertainty(estimator, name, folder, config)
    registered = ESTIMATORS.names()
    if name not in registered:
        known = sorted({*model_names(), *registered})
        raise UnknownNameError("estimator (a bundled name or a run folder, or one that is not trained)", name, known)
    target = ESTIMATORS.get(name)
    if is_trainable(target):
        raise TrainingError(f"{name} has no bundled weights: train it first, and predict with the run folder")
    if isinstance(target, Configurable):
        return target.configured(config)
    default = PredictConfig()
    own = default.selection, default.refine, default.refiner_iterations
    if (config.selection, config.refine, config.refiner_iterations) != own:
        raise InputError(
            f"{name} selects and refines in its own way; leave --selection, --refine and --refiner-iterations out"
        )
    if config.time_of_flight:
        raise InputError(f"{name} weighs readings in its own way; leave --time-of-flight out")
    made: PoseEstimator = target()
    return _with_uncertainty(made, name, data_folder("models") / name, config)


def _with_uncertainty(estimator: PoseEstimator, name: str, folder: Path, config: PredictConfig) -> PoseEstimator:
    """Return an estimator that says what it thinks of its poses, where that was fitted for these settings."""
    model = read_uncertainty(folder).get(config.selection, config.refine) if config.uncertainty else None
    if model is not None:
        meshes = read_meshes(folder) if (folder / MESHES).is_file() else None
        return WithUncertainty(estimator, model, meshes, config.reject, config.seed, config.reject_blocked)
    if config.reject is not None or config.reject_blocked:
        raise InputError(
            f"{name} cannot reject: no uncertainty was fitted for --selection {config.selection} "
            f"--refine {config.refine}; "
            "leave --reject out, and --reject-blocked, or choose settings that uncertainty.yaml of its folder names"
        )
    return estimator
