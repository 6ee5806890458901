"""The one training job: a family gives network, loss, samples and settings; folder, resume and records are shared."""

import hashlib
import os
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import torch
from torch import nn

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.learning import run_folder
from warehouse_sim.learning.checkpoint import latest_checkpoint
from warehouse_sim.learning.clock import Clock
from warehouse_sim.learning.compute import cpu_threads
from warehouse_sim.learning.loop import Order, Task, fit
from warehouse_sim.learning.observer import Observer, StepForecast, TrainingState
from warehouse_sim.learning.parallel import Worker, start_workers
from warehouse_sim.learning.records import CurveWriter, EventWriter, ProgressReporter, RunLog
from warehouse_sim.learning.run_folder import WEIGHTS, RunConfig, Source, read_weights
from warehouse_sim.learning.samples.stream_window import AwaitedStream
from warehouse_sim.learning.settings import LoopConfig, Progress
from warehouse_sim.learning.trainable import OpenStream, TrainableNetwork
from warehouse_sim.output import writing
from warehouse_sim.resources import cache_folder, model_dir


@dataclass(frozen=True, eq=False)
class Started:
    """What a training runs on."""

    task: Task
    """What is trained."""
    order: Order
    """Samples of each step."""
    config: RunConfig
    """The resolved configuration."""
    counts: Mapping[str, int]
    """Samples of each split that is held."""
    remark: str = ""
    """What else the diary says of them."""


@dataclass(frozen=True)
class TrainingJob(ABC):
    """What every process of a training must know; it is sent to each. A family says what is trained."""

    method: TrainableNetwork
    """What is trained, by name."""
    data: tuple[Path, ...]
    """Dataset folders."""
    run: Path
    """The run folder."""
    config: LoopConfig
    """Settings."""
    cache: Path | None = None
    """Folder that keeps samples; by default one of the user's, ``Path("none")`` for none."""
    open_stream: OpenStream | None = None
    """Opens the stream that the settings name."""

    run_config: ClassVar[type[RunConfig]]
    """Of its run folders."""
    samples: ClassVar[str]
    """What its samples are, in the plural ("crops")."""
    kept: ClassVar[str] = "images"
    """Of the user's cache folders, the one that keeps its samples."""
    watched: ClassVar[tuple[str, str]]
    """Metric of the validation that is reported while a run goes on, and how: its value stands for {}."""

    @property
    @abstractmethod
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""

    @abstractmethod
    def start(self, progress: Progress | None = None) -> Started:
        """Read the samples and make the network as it begins."""

    def settings(self, start: str | Path | None) -> LoopConfig:
        """Return the settings, completed by those of the weights that training begins with, if any."""
        return self.config

    def begin_with(self, init: str | Path, started: Started, log: RunLog) -> Source:
        """Copy weights that were trained before, and return what they were."""
        return start_from(init, started.task.network)

    def finish(self, started: Started) -> None:  # noqa: B027  most have nothing
        """Write what the run folder holds beside the weights."""

    @property
    def cache_dir(self) -> Path | None:
        """Folder that keeps samples; None keeps them in memory."""
        return cache_folder(self.kept) if self.cache is None else (None if self.cache == Path("none") else self.cache)

    def readers(self) -> list[DatasetReader]:
        """Open the datasets.

        Raises:
            DatasetError: A folder is no dataset that can be read.
            TrainingError: There is none.
        """
        if not self.data:
            raise TrainingError("there is nothing to train on: name at least one dataset folder")
        return [DatasetReader(folder) for folder in self.data]

    def origin(self, readers: Sequence[DatasetReader]) -> dict[str, Any]:
        """Return what ``config.yaml`` says of any run: who was trained by which version, on what, and how."""
        return {
            "estimator": self.method.name,
            "version": run_folder.package_version(),
            "datasets": run_folder.dataset_sources(readers),
            "train": self.config,
        }

    def clock(self) -> Clock:
        """Start a clock."""
        config = self.config
        return Clock(config.max_steps, config.max_minutes * 60.0 if config.max_minutes else None)

    def threads(self) -> AbstractContextManager[None]:
        """Use the CPU threads of one process."""
        fraction = 1 if self.is_small else max(1, (os.cpu_count() or 1) // self.config.devices)
        return cpu_threads(self.config.threads or fraction)


def train_job(
    job: TrainingJob, resume: bool = False, progress: Progress | None = None, init: str | Path | None = None
) -> Path:
    """Train what a job describes; other arguments and errors are those of ``estimators.train.train``."""
    run, name = job.run, job.method.name
    old = job.run_config.read(run) if run_folder.claim_folder(run, resume) else None
    before = old.started_from.name if old and old.started_from else None
    # Left out, on resuming, are all settings.
    if not (old and job.config == job.config.defaults()):
        job = replace(job, config=job.settings(init or before))
    if old:
        _require_same(old, job)
        job, init = replace(job, config=old.train), before
    log, names = RunLog(run / run_folder.LOG), ", ".join(map(str, job.data))
    what = " ".join(filter(None, ("resume" if old else "train", name, job.config.size)))
    log.note(f"{what} on {names}, torch {torch.__version__}")
    with _fed(job, progress) as (job, stream), job.threads():
        clock, started = job.clock(), job.start(progress)
        if old and old.datasets != started.config.datasets:
            other = ", ".join(source.name for source in old.datasets)
            raise TrainingError(f"{run} was trained on other data ({other}) than {names}; resume with the same")
        begun = job.begin_with(init, started, log) if init else None
        replace(started.config, started_from=begun).write(run)
        log.note(", ".join(f"{count} {job.samples} of {split}" for split, count in started.counts.items()))
        if started.remark:
            log.note(started.remark)
        with start_workers(job.config.devices, _work, job) as worker:
            observers = _observers(job, log, progress)
            state = fit(started.task, started.order, job.config, clock, run, worker, observers)
        result = _result(state, started.task.network)
        result |= {f"{split}_{job.samples}": count for split, count in started.counts.items()}
        if stream:
            filling, waited = round(stream.filling_s, 1), round(stream.fraction(), 3)
            result |= {"stream_filling_seconds": filling, "stream_waited_fraction": waited}
            log.note(f"the stream took {filling} s to fill; of the time since, {waited:.0%} was spent waiting for it")
    run_folder.write_weights(run, started.task.network)
    job.finish(started)
    run_folder.write_result(run, result)
    log.note(f"done: {result['samples']} samples in {result['seconds']} s on {result['device']}, {result['precision']}")
    return run


def start_from(init: str | Path, network: nn.Module) -> Source:
    """Copy all weights of a run that the network has, too, in the same shape, and return what they were.

    Args:
        init: Bundled name or run folder.
        network: What begins; weights for other classes or inputs stay fresh.

    Raises:
        UnknownNameError: Neither a bundled name nor a folder.
        TrainingError: The run has no weights, or none that fit.
    """
    folder = model_dir(init)
    given, own = read_weights(folder), network.state_dict()
    fitting = {name: value for name, value in given.items() if name in own and own[name].shape == value.shape}
    if len(fitting) < len(own) / 2:
        raise TrainingError(f"{folder / WEIGHTS} fits {len(fitting)} of {len(own)} arrays of the network; begin afresh")
    with torch.no_grad():
        network.load_state_dict(own | fitting)
    return starting_weights(init, folder / WEIGHTS)


def starting_weights(init: str | Path, file: Path) -> Source:
    """Return what says which weights a training began with."""
    return Source(str(init), hashlib.sha256(file.read_bytes()).hexdigest())


@contextmanager
def _fed(job: TrainingJob, progress: Progress | None) -> Iterator[tuple[TrainingJob, AwaitedStream | None]]:
    """Give a job, and the stream that feeds it if its settings name one; that is closed in the end."""
    if not job.config.fed_by or job.open_stream is None:
        yield job, None
        return
    with closing(AwaitedStream(job.open_stream, progress)) as stream:
        yield replace(job, open_stream=stream), stream


def _require_same(old: RunConfig, job: TrainingJob) -> None:
    if old.estimator != job.method.name:
        raise TrainingError(f"{job.run} is a run of {old.estimator}, not of {job.method.name}; choose another folder")
    if job.config not in (old.train, old.train.defaults()):
        raise TrainingError(f"{job.run} goes on with the settings in its {run_folder.CONFIG}; leave other settings out")


def _work(worker: Worker, job: TrainingJob) -> None:
    """Train beside rank 0, in a process of its own that leaves nothing behind."""
    with job.threads():
        clock, started = job.clock(), job.start()
        fit(started.task, started.order, job.config, clock, job.run, worker)


def _observers(job: TrainingJob, log: RunLog, progress: Progress | None) -> list[Observer]:
    """Return what writes the curves; those of a session that left no checkpoint are begun again."""
    curves, minutes = job.run / run_folder.CURVES, job.config.max_minutes
    if latest_checkpoint(job.run) is None:
        with writing(curves):
            curves.unlink(missing_ok=True)
    observers: list[Observer] = [CurveWriter(curves), EventWriter(job.run / run_folder.EVENTS), log]
    if progress:
        observers.append(ProgressReporter(progress, *job.watched))
    return [*observers, StepForecast(minutes)] if minutes else observers


def _result(state: TrainingState, network: nn.Module) -> dict[str, Any]:
    """Return what ``result.json`` says of any run."""
    samples, clock = state.step * state.config.batch, state.clock
    return {
        **{name: round(value, 3) for name, value in state.metrics.items()},
        "steps": state.step,
        "samples": samples,
        "seconds": round(clock.spent(), 1),
        "samples_per_second": round(samples / max(clock.trained(), 1e-9), 1),
        "parameters": sum(parameter.numel() for parameter in network.parameters()),
        "precision": state.precision,
        "device": str(state.device),
        "devices": state.config.devices,
        "threads": torch.get_num_threads(),
        "torch": torch.__version__,
    }
