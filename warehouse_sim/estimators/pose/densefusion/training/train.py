"""Train a network of the family on dataset folders and leave a run folder."""

import os
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import torch

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropSet
from warehouse_sim.estimators.pose.densefusion.methods import Method
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.objects import dataset_meshes, shape_tensors, write_meshes
from warehouse_sim.estimators.pose.densefusion.run_config import RunConfig, read_config, write_config
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.pose.densefusion.training.preparation import Prepared, prepare
from warehouse_sim.estimators.pose.densefusion.training.start import settings_from, start_at_mean_rotation, start_from
from warehouse_sim.estimators.pose.densefusion.training.streamed_crops import (
    OpenStream,
    StreamedCrops,
    StreamOrder,
    sampling_weights,
)
from warehouse_sim.estimators.pose.densefusion.training.task import PoseTask
from warehouse_sim.learning import run_folder
from warehouse_sim.learning.checkpoint import latest_checkpoint
from warehouse_sim.learning.clock import Clock
from warehouse_sim.learning.compute import cpu_threads
from warehouse_sim.learning.loop import fit
from warehouse_sim.learning.observer import Observer, StepForecast, TrainingState
from warehouse_sim.learning.parallel import Worker, start_workers
from warehouse_sim.learning.records import CurveWriter, EventWriter, ProgressReporter, RunLog
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.settings import Progress
from warehouse_sim.output import writing
from warehouse_sim.resources import cache_folder


def train_method(
    method: Method,
    data: Sequence[Path],
    run: Path,
    config: TrainConfig,
    resume: bool = False,
    progress: Progress | None = None,
    init: str | Path | None = None,
    cache: Path | None = None,
    open_stream: OpenStream | None = None,
) -> Path:
    """Train ``method``; arguments and errors are those of ``warehouse_sim.estimators.train.train``."""
    old = read_config(run) if run_folder.claim_folder(run, resume) else None
    if start := init or (old.started_from.name if old and old.started_from else None):
        # Left out, on resuming, are all settings.
        config = config if old and config == TrainConfig() else settings_from(start, config)
    if old:
        _require_same(old, method.name, config, run)
    job = _Job(method, tuple(data), run, old.train if old else config, _crops_folder(cache), open_stream)
    if job.config.phase == "refiner" and not start:
        raise TrainingError("phase refiner trains on top of a network: name it with --init, a bundled name or a run")
    log = RunLog(run / run_folder.LOG)
    names = ", ".join(map(str, data))
    log.note(f"{'resume' if old else 'train'} {method.name} {job.config.size} on {names}, torch {torch.__version__}")
    with job.threads():
        clock, prepared = job.clock(), job.prepare(progress)
        if old and old.datasets != prepared.config.datasets:
            before = ", ".join(source.name for source in old.datasets)
            raise TrainingError(f"{run} was trained on other data ({before}) than {names}; resume with the same")
        network, prepared = _begin(prepared, init, old)
        write_config(run, prepared.config)
        log.note(", ".join(f"{len(crops)} crops of {split}" for split, crops in prepared.crops.items()))
        if prepared.streamed:
            log.note(f"train: the stream of {job.config.stream.recipe}, seed {job.config.stream.seed}")
        with start_workers(job.config.devices, _run_worker, job) as worker:
            observers = _observers(run, job.config.max_minutes, log, progress)
            state = train_network(prepared, network, clock, run, worker, observers)
        result = _result(state, network, prepared)
    run_folder.write_weights(run, network)
    write_meshes(run, dataset_meshes(data, prepared.config.objects))
    run_folder.write_result(run, result)
    log.note(f"done: {result['samples']} samples in {result['seconds']} s on {result['device']}, {result['precision']}")
    return run


def train_network(
    prepared: Prepared,
    network: DenseFusion,
    clock: Clock,
    run: Path,
    worker: Worker = Worker(),  # noqa: B008  frozen
    observers: Sequence[Observer] = (),
) -> TrainingState:
    """Train ``network`` in one process, which may be one of several, and leave it with the averaged weights.

    Args:
        prepared: Crops and configuration.
        network: What is trained; processes of other rank than 0 get the weights of rank 0.
        clock: Progress of the run.
        run: Run folder; a checkpoint in it is gone on from.
        worker: Which process this is.
        observers: Notified of what happens; given in rank 0 only.
    """
    config, streamed = prepared.config.train, prepared.streamed
    crops: dict[str, CropSet | StreamedCrops] = {**prepared.crops}
    order: SampleOrder | StreamOrder
    if streamed:
        crops["train"] = streamed
        order = StreamOrder(streamed, config.batch, config.seed, prepared.classes, config.balance)
    else:
        train = prepared.crops["train"]
        weights = sampling_weights(train.class_index, prepared.classes, config.balance)
        order = SampleOrder(len(train), config.batch, config.seed, weights)
    task = PoseTask(network, shape_tensors(prepared.config.objects), config, crops, prepared.config.crop)
    return fit(task, order, config, clock, run, worker, observers)


@dataclass(frozen=True)
class _Job:
    """What every process of a training must know."""

    method: Method
    data: tuple[Path, ...]
    run: Path
    config: TrainConfig
    cache: Path | None
    open_stream: OpenStream | None = None

    def prepare(self, progress: Progress | None = None) -> Prepared:
        """Return crops and configuration."""
        return prepare(self.method, self.data, self.config, self.cache, progress, self.open_stream)

    def clock(self) -> Clock:
        """Start a clock."""
        config = self.config
        return Clock(config.max_steps, config.max_minutes * 60.0 if config.max_minutes else None)

    def threads(self) -> AbstractContextManager[None]:
        """Use the CPU threads of one process."""
        config = self.config
        fraction = 1 if config.size == "nano" else max(1, (os.cpu_count() or 1) // config.devices)
        return cpu_threads(config.threads or fraction)


def _run_worker(worker: Worker, job: _Job) -> None:
    """Train beside rank 0, in a process of its own that leaves nothing behind."""
    with job.threads():
        clock, prepared = job.clock(), job.prepare()
        network = DenseFusion(prepared.config.network, len(prepared.config.objects))
        train_network(prepared, network, clock, job.run, worker)


def _begin(prepared: Prepared, init: str | Path | None, old: RunConfig | None) -> tuple[DenseFusion, Prepared]:
    """Return the network as training begins with it, and the configuration that says so."""
    config = prepared.config
    torch.manual_seed(config.train.seed)
    network = DenseFusion(config.network, len(config.objects))
    start_at_mean_rotation(network, prepared.first_crops, config.objects)
    if old:
        init = old.started_from.name if old.started_from else None
    only_refiner = config.train.phase == "refiner"
    started_from = start_from(init, network, config.objects, all_known=only_refiner) if init else None
    return network, replace(prepared, config=replace(config, started_from=started_from))


def _observers(run: Path, minutes: float | None, log: RunLog, progress: Progress | None) -> list[Observer]:
    """Return what writes the curves; those of a session that left no checkpoint are begun again."""
    if latest_checkpoint(run) is None:
        with writing(run / run_folder.CURVES):
            (run / run_folder.CURVES).unlink(missing_ok=True)
    observers: list[Observer] = [CurveWriter(run / run_folder.CURVES), EventWriter(run / run_folder.EVENTS), log]
    if progress:
        words = "validation within 5 % of diameter {:.1f} %"
        observers.append(ProgressReporter(progress, "val_within_5_percent", words))
    return [*observers, StepForecast(minutes)] if minutes else observers


def _crops_folder(cache: Path | None) -> Path | None:
    if cache is None:
        return cache_folder("crops")
    return None if cache == Path("none") else cache


def _require_same(old: RunConfig, estimator: str, config: TrainConfig, run: Path) -> None:
    if old.estimator != estimator:
        raise TrainingError(f"{run} is a run of {old.estimator}, not of {estimator}; choose another folder")
    if config not in (old.train, TrainConfig()):
        raise TrainingError(f"{run} goes on with the settings in its {run_folder.CONFIG}; leave other settings out")


def _result(state: TrainingState, network: DenseFusion, prepared: Prepared) -> dict[str, Any]:
    samples, clock = state.step * state.config.batch, state.clock
    return {
        **{name: round(value, 3) for name, value in state.metrics.items()},
        "steps": state.step,
        "samples": samples,
        "seconds": round(clock.spent(), 1),
        "samples_per_second": round(samples / max(clock.trained(), 1e-9), 1),
        **{f"{split}_crops": len(crops) for split, crops in prepared.crops.items()},
        "parameters": sum(parameter.numel() for parameter in network.parameters()),
        "precision": state.precision,
        "device": str(state.device),
        "devices": state.config.devices,
        "threads": torch.get_num_threads(),
        "torch": torch.__version__,
    }
