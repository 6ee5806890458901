"""Train an estimator by name."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.errors import InputError, UnknownNameError
from warehouse_sim.estimators.api import Trainable
from warehouse_sim.estimators.registries import DETECTORS, ESTIMATORS, SEGMENTERS, is_trainable
from warehouse_sim.learning.settings import LoopConfig, Progress
from warehouse_sim.learning.trainable import OpenStream, TrainableNetwork
from warehouse_sim.one_writer import one_writer


def train(
    estimator: str,
    data: Path | Sequence[Path],
    run: Path,
    config: LoopConfig,
    resume: bool = False,
    progress: Progress | None = None,
    init: str | Path | None = None,
    cache: Path | None = None,
    open_stream: OpenStream | None = None,
) -> Path:
    """Train ``estimator`` on the train splits of ``data``, watch it on their val splits, and return the run folder.

    Args:
        estimator: Registered name.
        data: One or several dataset folders with BOP files; objects of one number must be one geometry.
        run: Folder to fill; must be new or empty unless ``resume``.
        config: Settings, of the type that the estimator takes. A resumed run goes on with its own; give the same or
            the defaults.
        resume: Go on from the last checkpoint in ``run``, or begin if there is none.
        progress: Called with the fraction that is done and what is going on.
        init: Bundled estimator or run folder whose weights training begins with; fresh ones by default.
        cache: Folder that keeps the crops for the next training, by default one in the user's cache folder;
            ``Path("none")`` keeps them in memory.
        open_stream: Gives the observations of the stream that ``config`` names, from a number on; what trains on them
            reads no train split.

    Raises:
        UnknownNameError: No such estimator, or nothing to begin with of that name.
        InputError: The estimator needs no training.
        DatasetError: A folder of ``data`` is no dataset with BOP files.
        OutputError: The run folder cannot be written, or another process trains into it.
        TrainingError: A split, the run folder or the weights to begin with cannot be used.
    """
    folders = (data,) if isinstance(data, Path) else tuple(data)
    method = trainable(estimator)
    # A stranger's knows no streams.
    streams: dict[str, Any] = {"open_stream": open_stream} if isinstance(method, TrainableNetwork) else {}
    # Two that train into one folder would take each other's checkpoints for their own.
    with one_writer(run):
        return method.train(folders, run, config, resume, progress, init, cache, **streams)


def trainable(name: str) -> Trainable:
    """Return what trains an estimator, a detector or a segmenter.

    Raises:
        UnknownNameError: No such name.
        InputError: It needs no training.
    """
    registries = (ESTIMATORS, DETECTORS, SEGMENTERS)
    found = next((registry.get(name) for registry in registries if name in registry.names()), None)
    if found is None:
        known = [other for registry in registries for other in registry.names() if is_trainable(registry.get(other))]
        raise UnknownNameError("estimator", name, known)
    if not is_trainable(found):
        raise InputError(f"{name} needs no training; use it at once: warehouse-sim predict {name} --data ... --out ...")
    trained: Trainable = found
    return trained
