"""Networks that a suite trains itself, kept and used again like all else."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any

from warehouse_sim.benchmark.entrants.entrant import Evaluated, Group
from warehouse_sim.benchmark.entrants.ways import Way
from warehouse_sim.benchmark.kept import folder_for, is_kept, keep
from warehouse_sim.benchmark.suite import TrainingConfig
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.estimators.train import train
from warehouse_sim.version import __version__

_ALONE = PredictConfig(selection="consensus", refine="none")
"""What networks that are compared answer by: themselves."""
Fraction = Callable[[float, str], None]


@dataclass(frozen=True)
class OneTraining:
    """One network of a suite: a length and a seed."""

    shown: str
    """As tables call it."""
    estimator: str
    roots: tuple[Path, ...]
    """Datasets."""
    steps: int
    config: TrainConfig
    out: Path
    """Folder of the benchmark."""

    @cached_property
    def _inputs(self) -> dict[str, Any]:
        return {
            "kind": "training",
            "estimator": self.estimator,
            "data": [DatasetReader(root).digest for root in self.roots],
            "settings": to_mapping(self.config),
            "version": __version__,
        }

    @property
    def run(self) -> Path:
        """Its run folder."""
        return folder_for(self.out / "runs", f"{self.shown}-seed{self.config.seed}", self._inputs)

    @property
    def is_made(self) -> bool:
        """Whether it was trained before, to its end."""
        return is_kept(self.run, self._inputs)

    def make(self, progress: Fraction = lambda fraction, note: None) -> Path:
        """Return its run folder, trained first, or to its end, where it is not.

        Raises:
            TrainingError: The data hold nothing to learn from.
        """
        run, crops = self.run, self.out / "crops"
        if not self.is_made:
            train(self.estimator, self.roots, run, self.config, resume=run.exists(), progress=progress, cache=crops)
            keep(run, self._inputs)
        return run


def trained(
    name: str,
    training: TrainingConfig,
    data: Mapping[str, Path],
    out: Path,
    progress: Fraction = lambda fraction, note: None,
) -> Iterator[Group]:
    """Yield an entrant for each length of a training, with one member for each seed, trained where it is missing.

    It is called ``NAME@STEPS``, or ``NAME`` where there is one length.

    Args:
        name: Of the training.
        training: What is trained, on what, for how long.
        data: Folders by name.
        out: Folder of the benchmark; runs are under ``runs``.
        progress: Called with the fraction of one training that is done.

    Raises:
        ConfigError: The settings are none of training.
        TrainingError: The data hold nothing to learn from.
    """
    for shown, alike in groupby(trainings_of(name, training, data, out), key=lambda one: one.shown):
        some = list(alike)
        members = tuple(Evaluated(shown, Way(str(one.make(progress)), _ALONE), trainings=1) for one in some)
        yield Group(shown, members, {"samples": some[0].steps * some[0].config.batch})


def trainings_of(name: str, training: TrainingConfig, data: Mapping[str, Path], out: Path) -> list[OneTraining]:
    """Return what is trained: of each length one for each seed.

    Args:
        name: Of the training.
        training: What is trained, on what, for how long.
        data: Folders by name.
        out: Folder of the benchmark.

    Raises:
        ConfigError: The settings are none of training.
    """
    roots = tuple(data[item] for item in training.data)
    return [
        OneTraining(
            f"{name}@{steps}" if len(training.steps) > 1 else name,
            training.estimator,
            roots,
            steps,
            settings_of(name, training, steps, seed),
            out,
        )
        for steps in training.steps
        for seed in training.seeds
    ]


def settings_of(name: str, training: TrainingConfig, steps: int, seed: int) -> TrainConfig:
    """Return the settings of one training.

    Raises:
        ConfigError: One of them is none of training.
    """
    plain = {"max_minutes": None, "max_steps": steps, "seed": seed, "threads": 1, "workers": 1, "validations": 1}
    return from_mapping(TrainConfig, plain | training.settings, f"trainings: {name}: settings")
