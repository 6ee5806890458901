"""Networks that a suite trains itself, kept and used again like all else."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from warehouse_sim import __version__
from warehouse_sim.benchmark.entrants import Asked, Group
from warehouse_sim.benchmark.kept import folder_for, is_kept, keep
from warehouse_sim.benchmark.suite import TrainingConfig
from warehouse_sim.benchmark.ways import Way
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.estimators.train import train

_ALONE = PredictConfig(selection="consensus", refine="none")
"""What networks that are compared answer by: themselves."""


def trained(
    name: str,
    training: TrainingConfig,
    data: Mapping[str, Path],
    out: Path,
    progress: Callable[[float, str], None] = lambda share, note: None,
) -> Iterator[Group]:
    """Yield an entrant for each length of a training, with one member for each seed, trained where it is missing.

    It is called ``NAME@STEPS``, or ``NAME`` where there is one length.

    Args:
        name: Of the training.
        training: What is trained, on what, for how long.
        data: Folders by name.
        out: Folder of the benchmark; runs are under ``runs``.
        progress: Called with the share of one training that is done.

    Raises:
        ConfigError: The settings are none of training.
        TrainingError: The data hold nothing to learn from.
    """
    roots = [data[item] for item in training.data]
    for steps in training.steps:
        shown = f"{name}@{steps}" if len(training.steps) > 1 else name
        members, batch = [], TrainConfig().batch
        for seed in training.seeds:
            config = settings_of(name, training, steps, seed)
            batch = config.batch
            run = _run(shown, training.estimator, roots, config, out, progress)
            members.append(Asked(shown, Way(str(run), _ALONE), trainings=1))
        yield Group(shown, tuple(members), {"samples": steps * batch})


def settings_of(name: str, training: TrainingConfig, steps: int, seed: int) -> TrainConfig:
    """Return the settings of one training.

    Raises:
        ConfigError: One of them is none of training.
    """
    plain = {"max_minutes": None, "max_steps": steps, "seed": seed, "threads": 1, "workers": 1, "validations": 1}
    return from_mapping(TrainConfig, plain | training.settings, f"trainings: {name}: settings")


def _run(
    shown: str,
    estimator: str,
    roots: Sequence[Path],
    config: TrainConfig,
    out: Path,
    progress: Callable[[float, str], None],
) -> Path:
    inputs = {
        "kind": "training",
        "estimator": estimator,
        "data": [DatasetReader(root).digest for root in roots],
        "settings": to_mapping(config),
        "version": __version__,
    }
    run = folder_for(out / "runs", f"{shown}-seed{config.seed}", inputs)
    if not is_kept(run, inputs):
        train(estimator, roots, run, config, resume=run.exists(), progress=progress, cache=out / "crops")
        keep(run, inputs)
    return run
