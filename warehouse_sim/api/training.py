"""Estimators by name: open one, train one."""

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from warehouse_sim.api.arguments import checked, settings_of
from warehouse_sim.api.dataset import Dataset
from warehouse_sim.errors import DatasetError
from warehouse_sim.learning.settings import LoopConfig, Progress, StreamConfig
from warehouse_sim.optional import require_extra

if TYPE_CHECKING:
    from warehouse_sim.estimators.api import PoseEstimator
    from warehouse_sim.generation.recipe import Recipe
    from warehouse_sim.schema import Observation

log = logging.getLogger(__name__)


@checked
def load_estimator(name: str | Path | Callable[..., Any] | object, **settings: Any) -> "PoseEstimator":
    """Return an estimator, which takes an ``RgbdImage`` and returns poses.

    Example:
        >>> estimator = ws.load_estimator("front-fit")
        >>> estimates = estimator.estimate(ws.RgbdImage.from_arrays(np.ones((48, 64)), np.diag([50.0, 50.0, 1.0]), ()))

    Args:
        name: A name, a run folder, "file.py:Class", "module:Class", an object with ``estimate(image)``, or a function
            that takes an ``RgbdImage`` and returns a list of ``PoseEstimate``.
        settings: Settings by name, as ``predict`` takes them.

    Raises:
        UnknownNameError: No estimator has that name.
        TrainingError: The folder holds no complete run.
    """
    require_extra("learn", "to load an estimator")
    from warehouse_sim.estimators.load import load_estimator as load
    from warehouse_sim.estimators.settings import PredictConfig

    return load(name, settings_of(PredictConfig(), settings, "load_estimator"))


@checked
def train(
    estimator: str,
    data: Dataset | str | Path | Sequence[Dataset | str | Path],
    out: str | Path,
    resume: bool = False,
    init: str | Path | None = None,
    cache: str | Path | None = None,
    preset: Literal["plain", "robust"] = "plain",
    progress: Progress | None = None,
    **settings: Any,
) -> Path:
    """Train an estimator, a detector or a segmenter on the train split, watch it on val; test is never read.

    Example:
        >>> ws.train("densefusion-pointcloud", "out", "run", max_steps=2, batch=2, cache="none").name
        'run'

    Args:
        estimator: Its name.
        data: One dataset or several; objects of one number must be one geometry.
        out: Run folder to make, which ``predict`` takes.
        resume: Go on with a run that was interrupted.
        init: Name or run folder whose weights training begins with; fresh ones by default.
        cache: Folder that keeps crops for the next training, by default in the user's cache folder; "none" keeps them
            in memory.
        preset: What settings are that are not given: "robust" gives the network what is around masks, disturbs these
            and turns clouds upright by gravity.
        progress: Called with the fraction that is done and a note.
        settings: Settings by name, as the options of ``warehouse-sim train``: ``max_minutes=20``, ``batch=32``, ...

    Returns:
        The run folder.

    Raises:
        UnknownNameError: No such name.
        TrainingError: A split or the run folder cannot be used.
    """
    require_extra("learn", "to train")
    from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig, with_preset
    from warehouse_sim.estimators.train import trainable

    config = settings_of(getattr(trainable(estimator), "settings", None) or TrainConfig(), settings, "train")
    if isinstance(config, TrainConfig):
        config = with_preset(config, preset)
    place = None if cache is None else Path(cache)
    remark = fit(estimator, _folders(data), Path(out), config, resume, init, place, lambda stage: nullcontext(progress))
    if remark:
        log.info("%s", remark)
    return Path(out)


def fit(
    estimator: str,
    data: Sequence[Path],
    out: Path,
    config: LoopConfig,
    resume: bool,
    init: str | Path | None,
    cache: Path | None,
    stage: Callable[[str], AbstractContextManager[Progress | None]],
) -> str:
    """Do what ``train`` says with all settings, and return what there is to say of it.

    Args:
        estimator: As in ``train``.
        data: Dataset folders.
        out: As in ``train``.
        config: All settings of that estimator.
        resume: As in ``train``.
        init: As in ``train``.
        cache: As in ``train``.
        stage: Opens what shows how far the stage of that name is.
    """
    require_extra("learn", "to train")
    from warehouse_sim.estimators.train import train as run
    from warehouse_sim.estimators.train import trainable

    method = trainable(estimator)
    if config.fed_by:
        _stream_recipe(config.fed_by)  # Before splits are read, which may take long.
    with stage("training") as progress:
        run(estimator, data, out, config, resume, progress, init, cache, open_stream)
    with stage("calibrating") as progress:
        return method.calibrate(out, data, progress)


def open_stream(config: StreamConfig, start: int) -> "Iterator[Observation]":
    """Make the observations of a stream from a number on, with what networks of images read of them.

    Raises:
        MissingPackageError: What makes scenes is not installed.
        RecipeError: The recipe holds something that a recipe does not take.
    """
    from warehouse_sim.generation.stream import stream

    return stream(_stream_recipe(config), config.seed, config.workers, start, apart=True)


def _stream_recipe(config: StreamConfig) -> "Recipe":
    require_extra("generate", "to make the observations that are trained on")
    from warehouse_sim.generation.recipe import load_recipe

    return load_recipe(config.recipe, {"sensors": {"outputs": ["rgb", "depth", "masks", "poses"]}})


def _folders(data: Dataset | str | Path | Sequence[Dataset | str | Path]) -> list[Path]:
    items = [data] if isinstance(data, (Dataset, str, Path)) else list(data)
    folders = [item.path if isinstance(item, Dataset) else Path(item) for item in items]
    for folder in folders:
        if not folder.is_dir():
            raise DatasetError(f"{folder}: is not a folder; name the folder of a dataset, or generate one")
    return folders
