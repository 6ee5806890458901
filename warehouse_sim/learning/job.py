"""One training: processes, threads, clock and observers around the loop, and the weights that it begins with."""

import hashlib
import os
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import torch
from torch import nn

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning import run_folder
from warehouse_sim.learning.checkpoint import latest_checkpoint
from warehouse_sim.learning.clock import Clock
from warehouse_sim.learning.compute import cpu_threads
from warehouse_sim.learning.loop import Task, fit
from warehouse_sim.learning.observer import Observer, StepForecast, TrainingState
from warehouse_sim.learning.parallel import Worker, start_workers
from warehouse_sim.learning.records import CurveWriter, EventWriter, ProgressReporter, RunLog
from warehouse_sim.learning.run_folder import WEIGHTS, StartingWeights, read_weights
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.settings import LoopConfig, Progress
from warehouse_sim.output import writing
from warehouse_sim.resources import model_dir


def start_from(init: str | Path, network: nn.Module) -> StartingWeights:
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
    return StartingWeights(str(init), hashlib.sha256((folder / WEIGHTS).read_bytes()).hexdigest())


class Started(Protocol):
    """What a training runs on."""

    @property
    def task(self) -> Task:
        """What is trained."""

    @property
    def order(self) -> SampleOrder:
        """Samples of each step."""


class Job(Protocol):
    """What every process of a training must know; it is sent to each."""

    @property
    def run(self) -> Path:
        """The run folder."""

    @property
    def config(self) -> LoopConfig:
        """Settings."""

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""

    def start(self, progress: Progress | None = None) -> Started:
        """Read the samples and make the network as it begins."""


@dataclass(frozen=True)
class Watched:
    """Which metric of the validation is reported while a run goes on."""

    metric: str
    words: str
    """The metric's value stands for {}."""


def job_clock(job: Job) -> Clock:
    """Start a clock."""
    config = job.config
    return Clock(config.max_steps, config.max_minutes * 60.0 if config.max_minutes else None)


def job_threads(job: Job) -> AbstractContextManager[None]:
    """Use the CPU threads of one process."""
    fraction = 1 if job.is_small else max(1, (os.cpu_count() or 1) // job.config.devices)
    return cpu_threads(job.config.threads or fraction)


def train_session(
    job: Job, started: Started, clock: Clock, log: RunLog, watched: Watched, progress: Progress | None = None
) -> TrainingState:
    """Train until the clock has run out and leave the task's network with the averaged weights.

    Args:
        job: What other processes of the training begin with.
        started: What this one has made of it.
        clock: Progress of the run.
        log: Log of the run folder.
        watched: What is reported.
        progress: Called with the fraction that is done and what is going on.

    Raises:
        TrainingError: A checkpoint cannot be read, another process failed, or the time does not suffice for a step.
        OutputError: The run folder cannot be written.
    """
    with start_workers(job.config.devices, _work, job) as worker:
        observers = _observers(job, log, watched, progress)
        return fit(started.task, started.order, job.config, clock, job.run, worker, observers)


def session_result(state: TrainingState, network: torch.nn.Module) -> dict[str, Any]:
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


def _work(worker: Worker, job: Job) -> None:
    """Train beside rank 0, in a process of its own that leaves nothing behind."""
    with job_threads(job):
        clock, started = job_clock(job), job.start()
        fit(started.task, started.order, job.config, clock, job.run, worker)


def _observers(job: Job, log: RunLog, watched: Watched, progress: Progress | None) -> Sequence[Observer]:
    """Return what writes the curves; those of a session that left no checkpoint are begun again."""
    curves, minutes = job.run / run_folder.CURVES, job.config.max_minutes
    if latest_checkpoint(job.run) is None:
        with writing(curves):
            curves.unlink(missing_ok=True)
    observers: list[Observer] = [CurveWriter(curves), EventWriter(job.run / run_folder.EVENTS), log]
    if progress:
        observers.append(ProgressReporter(progress, watched.metric, watched.words))
    return [*observers, StepForecast(minutes)] if minutes else observers
