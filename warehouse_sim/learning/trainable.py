"""What the name of a network stands for that must be trained first; free of torch until it is used."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.settings import LoopConfig, Progress, StreamConfig
from warehouse_sim.optional import require_extra
from warehouse_sim.resources import model_dir, model_names

if TYPE_CHECKING:
    from warehouse_sim.schema import Observation

OpenStream = Callable[[StreamConfig, int], Iterator["Observation"]]
"""Gives the observations of a stream from a number on."""


@dataclass(frozen=True)
class TrainableNetwork:
    """A network by name; called without arguments, it is opened with its bundled weights."""

    name: str
    summary: str
    """One line for people."""
    inputs: str
    """What it reads of an observation."""
    settings: LoopConfig
    """How it is trained by default; says the type of its settings, too."""

    job: ClassVar[str]
    """What trains it, a ``TrainingJob`` as "module:Class"."""
    opens: ClassVar[str] = ""
    """What opens a run folder of it, as "module:Class"."""
    extra: ClassVar[str] = ""
    """Of the package's extras, the one that it needs beside ``learn``."""

    def __call__(self) -> Any:
        """Open the bundled weights.

        Raises:
            TrainingError: There are none.
            MissingPackageError: A library is not installed.
        """
        if self.name not in model_names():
            raise TrainingError(f"{self.name} has no bundled weights: train it first, and give the run folder instead")
        return _found(self.opens)(model_dir(self.name))

    def train(
        self,
        data: Sequence[Path],
        run: Path,
        config: LoopConfig,
        resume: bool = False,
        progress: Progress | None = None,
        init: str | Path | None = None,
        cache: Path | None = None,
        open_stream: OpenStream | None = None,
    ) -> Path:
        """Train as ``warehouse_sim.estimators.train.train`` says; ``config`` must be of the type of ``settings``."""
        train_job = _found("warehouse_sim.learning.job:train_job")
        trained: Path = train_job(self.make_job(data, run, config, cache, open_stream), resume, progress, init)
        return trained

    def make_job(
        self,
        data: Sequence[Path],
        run: Path,
        config: LoopConfig,
        cache: Path | None = None,
        open_stream: OpenStream | None = None,
    ) -> Any:
        """Return the training of it, what ``job`` names.

        Raises:
            TrainingError: The settings are of another type.
            MissingPackageError: A library is not installed.
        """
        wanted = type(self.settings)
        if self.extra:
            require_extra(self.extra, f"to train {self.name}")
        if not isinstance(config, wanted):
            raise TrainingError(f"{self.name} is trained with a {wanted.__name__}, found a {type(config).__name__}")
        return _found(self.job)(self, tuple(data), run, config, cache, open_stream)

    def calibrate(self, run: Path, data: Sequence[Path], progress: Progress | None = None) -> str:
        """Do nothing: what is found ranks by its score, and nothing more is requested of it."""
        return ""


def _found(target: str) -> Any:
    module, _, name = target.partition(":")
    return getattr(import_module(module), name)
