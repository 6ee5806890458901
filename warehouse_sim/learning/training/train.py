"""Train an estimator on dataset folders and leave a run folder."""

import os
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import lightning
import torch

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning import run_folder
from warehouse_sim.learning.methods import ESTIMATORS
from warehouse_sim.learning.networks.densefusion import DenseFusion
from warehouse_sim.learning.object_meshes import dataset_meshes, write_meshes
from warehouse_sim.learning.progress import Progress
from warehouse_sim.learning.run_folder import RunConfig
from warehouse_sim.learning.settings import TrainConfig
from warehouse_sim.learning.threads import cpu_threads
from warehouse_sim.learning.training.clock import Clock
from warehouse_sim.learning.training.fit import Fitted, fit, latest_checkpoint
from warehouse_sim.learning.training.forecast import StepForecast
from warehouse_sim.learning.training.parallel import Place, companions
from warehouse_sim.learning.training.preparation import Prepared, prepare
from warehouse_sim.learning.training.quiet import quiet_lightning
from warehouse_sim.learning.training.records import CurveWriter, EventWriter, ProgressReporter
from warehouse_sim.learning.training.run_log import RunLog
from warehouse_sim.learning.training.start import start_at_mean_rotation
from warehouse_sim.learning.training.warm_start import start_from
from warehouse_sim.output import make_folder, writing
from warehouse_sim.resources import cache_folder


def train(
    estimator: str,
    data: Path | Sequence[Path],
    run: Path,
    config: TrainConfig,
    resume: bool = False,
    progress: Progress | None = None,
    init: str | Path | None = None,
    cache: Path | None = None,
) -> Path:
    """Train ``estimator`` on the train splits of ``data``, watch it on their val splits, and return the run folder.

    Args:
        estimator: Registered name.
        data: One or several dataset folders with BOP files; objects of one number must be one geometry.
        run: Folder to fill; must be new or empty unless ``resume``.
        config: Settings. A resumed run goes on with its own; give the same or the defaults.
        resume: Go on from the last checkpoint in ``run``, or begin if there is none.
        progress: Told the share that is done and what is going on.
        init: Bundled estimator or run folder whose weights training begins with; fresh ones by default.
        cache: Folder that keeps the crops for the next training, by default one in the user's cache folder;
            ``Path("none")`` keeps them in memory.

    Raises:
        UnknownNameError: No such estimator, or nothing to begin with of that name.
        DatasetError: A folder of ``data`` is no dataset with BOP files.
        OutputError: The run folder cannot be written.
        TrainingError: A split, the run folder or the weights to begin with cannot be used.
    """
    ESTIMATORS.get(estimator)
    old = _claim_folder(run, resume)
    if old:
        _require_same(old, estimator, config, run)
    folders = (data,) if isinstance(data, Path) else tuple(data)
    job = _Job(estimator, folders, run, old.train if old else config, _crops_folder(cache))
    log = RunLog(run / run_folder.LOG)
    names = ", ".join(map(str, folders))
    log.note(f"{'resume' if old else 'train'} {estimator} {job.config.size} on {names}, torch {torch.__version__}")
    with job.threads():
        clock, prepared = job.clock(), job.prepare(progress)
        if old and old.datasets != prepared.config.datasets:
            before = ", ".join(source.name for source in old.datasets)
            raise TrainingError(f"{run} was trained on other data ({before}) than {names}; resume with the same")
        network, prepared = _begin(prepared, init, old)
        run_folder.write_config(run, prepared.config)
        log.note(", ".join(f"{len(crops)} crops of {split}" for split, crops in prepared.crops.items()))
        with quiet_lightning(), companions(job.config.devices, _accompany, job) as place:
            observers = _observers(run, clock, job.config.max_minutes, log, progress)
            fitted = fit(prepared, network, clock, run, place, observers)
        result = _result(fitted, prepared)
    run_folder.write_weights(run, network)
    write_meshes(run, dataset_meshes(folders, prepared.config.objects))
    run_folder.write_result(run, result)
    log.note(f"done: {result['samples']} samples in {result['seconds']} s on {result['device']}, {result['precision']}")
    return run


@dataclass(frozen=True)
class _Job:
    """What every process of a training must know."""

    estimator: str
    data: tuple[Path, ...]
    run: Path
    config: TrainConfig
    cache: Path | None

    def prepare(self, progress: Progress | None = None) -> Prepared:
        """Return crops and configuration."""
        return prepare(ESTIMATORS.get(self.estimator), self.data, self.config, self.cache, progress)

    def clock(self) -> Clock:
        """Start a clock."""
        config = self.config
        return Clock(config.max_steps, config.max_minutes * 60.0 if config.max_minutes else None)

    def threads(self) -> AbstractContextManager[None]:
        """Use the CPU threads of one process."""
        config = self.config
        share = 1 if config.size == "nano" else max(1, (os.cpu_count() or 1) // config.devices)
        return cpu_threads(config.threads or share)


def _accompany(place: Place, job: _Job) -> None:
    """Train beside rank 0, in a process of its own that leaves nothing behind."""
    with job.threads(), quiet_lightning():
        clock, prepared = job.clock(), job.prepare()
        network = DenseFusion(prepared.config.network, len(prepared.config.objects))
        fit(prepared, network, clock, job.run, place)


def _begin(prepared: Prepared, init: str | Path | None, old: RunConfig | None) -> tuple[DenseFusion, Prepared]:
    """Return the network as training begins with it, and the configuration that says so."""
    config = prepared.config
    torch.manual_seed(config.train.seed)
    network = DenseFusion(config.network, len(config.objects))
    start_at_mean_rotation(network, prepared.crops["train"], config.objects)
    if old:
        init = old.started_from.name if old.started_from else None
    started_from = start_from(init, network, config.objects) if init else None
    return network, replace(prepared, config=replace(config, started_from=started_from))


def _observers(
    run: Path, clock: Clock, minutes: float | None, log: RunLog, progress: Progress | None
) -> list[lightning.Callback]:
    """Return what writes the curves; those of a session that left no checkpoint are begun anew."""
    if latest_checkpoint(run) is None:
        with writing(run / run_folder.CURVES):
            (run / run_folder.CURVES).unlink(missing_ok=True)
    forecasts = [StepForecast(clock, minutes)] if minutes else []
    reporters = [ProgressReporter(progress)] if progress else []
    return [*forecasts, CurveWriter(run / run_folder.CURVES), EventWriter(run / run_folder.EVENTS), log, *reporters]


def _crops_folder(cache: Path | None) -> Path | None:
    if cache is None:
        return cache_folder("crops")
    return None if cache == Path("none") else cache


def _claim_folder(run: Path, resume: bool) -> RunConfig | None:
    """Make the run folder, and return the configuration of the run to go on with, if any."""
    if resume and (run / run_folder.RESULT).is_file():
        raise TrainingError(f"{run} is complete, there is nothing to resume; choose another folder to train again")
    if resume and (run / run_folder.CONFIG).is_file():
        return run_folder.read_config(run)
    make_folder(run)
    # A run that was stopped while it read has left nothing but its log.
    if any(path.name != run_folder.LOG for path in run.iterdir()):
        raise TrainingError(f"{run} is not empty; resume the run in it, or choose another folder")
    return None


def _require_same(old: RunConfig, estimator: str, config: TrainConfig, run: Path) -> None:
    if old.estimator != estimator:
        raise TrainingError(f"{run} is a run of {old.estimator}, not of {estimator}; choose another folder")
    if config not in (old.train, TrainConfig()):
        raise TrainingError(f"{run} goes on with the settings in its {run_folder.CONFIG}; leave other settings out")


def _result(fitted: Fitted, prepared: Prepared) -> dict[str, Any]:
    module, trainer = fitted.module, fitted.trainer
    samples = trainer.global_step * module.config.batch
    return {
        **{name: round(value, 3) for name, value in module.metrics.items()},
        "steps": trainer.global_step,
        "samples": samples,
        "seconds": round(module.clock.spent(), 1),
        "samples_per_second": round(samples / max(module.clock.trained(), 1e-9), 1),
        "train_crops": len(prepared.crops["train"]),
        "val_crops": len(prepared.crops["val"]),
        "parameters": sum(parameter.numel() for parameter in module.network.parameters()),
        "precision": str(trainer.precision),
        "device": str(module.device),
        "devices": module.config.devices,
        "threads": torch.get_num_threads(),
        "torch": torch.__version__,
    }
