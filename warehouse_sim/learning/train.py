"""Train an estimator on a dataset folder and leave a run folder."""

from pathlib import Path
from typing import Any, cast

import lightning
import torch
from lightning.pytorch.callbacks import ModelCheckpoint
from torch.utils.data import DataLoader, Dataset

from warehouse_sim.errors import TrainingError
from warehouse_sim.learning import run_folder
from warehouse_sim.learning.clock import Clock
from warehouse_sim.learning.crop_set import CropSet
from warehouse_sim.learning.methods import ESTIMATORS
from warehouse_sim.learning.module import PoseTraining
from warehouse_sim.learning.networks.densefusion import DenseFusion
from warehouse_sim.learning.objects import shape_tensors
from warehouse_sim.learning.precision import choose_precision
from warehouse_sim.learning.preparation import prepare
from warehouse_sim.learning.progress import Progress
from warehouse_sim.learning.quiet import quiet_lightning
from warehouse_sim.learning.records import CurveWriter, ProgressReporter
from warehouse_sim.learning.run_folder import RunConfig
from warehouse_sim.learning.run_log import RunLog
from warehouse_sim.learning.settings import TrainConfig
from warehouse_sim.learning.start import start_at_mean_rotation
from warehouse_sim.learning.streams import BatchStream

_VALIDATION_BATCH = 64


def train(
    estimator: str,
    data: Path,
    run: Path,
    config: TrainConfig,
    resume: bool = False,
    progress: Progress | None = None,
) -> Path:
    """Train ``estimator`` on the train split of ``data``, watch it on val, and return the run folder.

    Args:
        estimator: Registered name.
        data: Dataset folder with BOP files.
        run: Folder to fill; must be new or empty unless ``resume``.
        config: Settings. A resumed run goes on with its own; give the same or the defaults.
        resume: Go on from the last checkpoint in ``run``, or begin if there is none.
        progress: Told the share that is done and what is going on.

    Raises:
        UnknownNameError: No such estimator.
        DatasetError: ``data`` is no dataset with BOP files.
        TrainingError: A split or the run folder cannot be used.
    """
    method = ESTIMATORS.get(estimator)
    old = _claim_folder(run, resume)
    if old:
        _require_same(old, estimator, config, run)
        config = old.train
    log = RunLog(run / run_folder.LOG)
    log.note(f"{'resume' if old else 'train'} {estimator} {config.size} on {data}, torch {torch.__version__}")
    clock = Clock(config.max_steps, config.max_minutes * 60.0 if config.max_minutes else None)
    crops, resolved = prepare(method, data, config, progress)
    if old and old.dataset_sha256 != resolved.dataset_sha256:
        raise TrainingError(f"{run} was trained on another dataset ({old.dataset}) than {data}; resume with that one")
    run_folder.write_config(run, resolved)
    torch.manual_seed(config.seed)
    network = DenseFusion(resolved.network, len(resolved.objects))
    start_at_mean_rotation(network, crops["train"], resolved.objects)
    module = PoseTraining(network, shape_tensors(resolved.objects), config, clock, crops)
    log.note(", ".join(f"{len(items)} crops of {split}" for split, items in crops.items()))
    with quiet_lightning():
        trainer = _fit(module, crops, run, [log, *([ProgressReporter(progress)] if progress else [])])
    run_folder.write_weights(run, network)
    result = _result(module, trainer, crops)
    run_folder.write_result(run, result)
    log.note(f"done: {result['samples']} samples in {result['seconds']} s on {result['device']}, {result['precision']}")
    return run


def _claim_folder(run: Path, resume: bool) -> RunConfig | None:
    """Make the run folder, and return the configuration of the run to go on with, if any."""
    if resume and (run / run_folder.RESULT).is_file():
        raise TrainingError(f"{run} is complete, there is nothing to resume; choose another folder to train again")
    if resume and (run / run_folder.CONFIG).is_file():
        return run_folder.read_config(run)
    if run.exists() and any(run.iterdir()):
        raise TrainingError(f"{run} is not empty; resume the run in it, or choose another folder")
    run.mkdir(parents=True, exist_ok=True)
    return None


def _require_same(old: RunConfig, estimator: str, config: TrainConfig, run: Path) -> None:
    if old.estimator != estimator:
        raise TrainingError(f"{run} is a run of {old.estimator}, not of {estimator}; choose another folder")
    if config not in (old.train, TrainConfig()):
        raise TrainingError(f"{run} goes on with the settings in its {run_folder.CONFIG}; leave other settings out")


def _fit(
    module: PoseTraining, crops: dict[str, CropSet], run: Path, observers: list[lightning.Callback]
) -> lightning.Trainer:
    config, clock = module.config, module.clock

    def reached(step: int) -> bool:
        return clock.fraction(step) >= (module.current_epoch + 1) / config.validations

    stream = BatchStream(len(crops["train"]), config.batch, config.seed, lambda: module.global_step, reached)
    # A sequence of index tensors is a dataset to torch, whatever its base class.
    validation = cast(Dataset[torch.Tensor], torch.arange(len(crops["val"])).split(_VALIDATION_BATCH))
    folder = run / run_folder.CHECKPOINTS
    checkpoint = next(iter(sorted(folder.glob("*.ckpt"), key=lambda path: path.stat().st_mtime, reverse=True)), None)
    if checkpoint is None:
        (run / run_folder.CURVES).unlink(missing_ok=True)
    savers: list[lightning.Callback] = [
        CurveWriter(run / run_folder.CURVES),
        ModelCheckpoint(folder, filename="{step}"),
    ]
    trainer = lightning.Trainer(
        max_epochs=config.validations,
        accelerator="cuda" if torch.cuda.is_available() else "cpu",
        precision=choose_precision(config.precision),
        gradient_clip_val=config.clip_norm,
        callbacks=[*savers, *observers],
        # One pass over val before the first step tells how much time the last one needs.
        num_sanity_val_steps=-1,
        logger=False,
        enable_progress_bar=False,
        enable_model_summary=False,
        devices=1,
    )
    clock.start_training()
    train_loader, val_loader = DataLoader(stream, batch_size=None), DataLoader(validation, batch_size=None)
    trainer.fit(module, train_loader, val_loader, ckpt_path=checkpoint, weights_only=True)
    return trainer


def _result(module: PoseTraining, trainer: lightning.Trainer, crops: dict[str, CropSet]) -> dict[str, Any]:
    samples = trainer.global_step * module.config.batch
    return {
        **{name: round(value, 3) for name, value in module.metrics.items()},
        "steps": trainer.global_step,
        "samples": samples,
        "seconds": round(module.clock.spent(), 1),
        "samples_per_second": round(samples / max(module.clock.trained(), 1e-9), 1),
        "train_crops": len(crops["train"]),
        "val_crops": len(crops["val"]),
        "parameters": sum(parameter.numel() for parameter in module.network.parameters()),
        "precision": str(trainer.precision),
        "device": str(module.device),
        "threads": torch.get_num_threads(),
        "torch": torch.__version__,
    }
