"""Train a network in one process, which may be one of several."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import cast

import lightning
import torch
from lightning.pytorch.callbacks import ModelCheckpoint
from lightning.pytorch.strategies import DDPStrategy
from torch.utils.data import DataLoader, Dataset

from warehouse_sim.learning.networks.densefusion import DenseFusion
from warehouse_sim.learning.objects import shape_tensors
from warehouse_sim.learning.run_folder import CHECKPOINTS
from warehouse_sim.learning.training.balance import sampling_weights
from warehouse_sim.learning.training.clock import Clock
from warehouse_sim.learning.training.ema import MovingAverage
from warehouse_sim.learning.training.module import PoseTraining
from warehouse_sim.learning.training.parallel import ActAsOne, OneMachine, Place
from warehouse_sim.learning.training.precision import choose_precision
from warehouse_sim.learning.training.preparation import Prepared
from warehouse_sim.learning.training.streams import BatchStream
from warehouse_sim.output import writing

_VALIDATION_BATCH = 64
_PATIENCE = timedelta(minutes=10)
"""How long processes wait for each other before they give up."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """What is left when a process is done."""

    trainer: lightning.Trainer
    module: PoseTraining


def fit(
    prepared: Prepared,
    network: DenseFusion,
    clock: Clock,
    run: Path,
    place: Place,
    observers: Sequence[lightning.Callback] = (),
) -> Fitted:
    """Train ``network`` until the clock has run out and leave it with the averaged weights.

    Args:
        prepared: Crops and configuration.
        network: What is trained; processes of other rank than 0 get the weights of rank 0.
        clock: Progress of the run.
        run: Run folder; a checkpoint in it is gone on from.
        place: Which process this is.
        observers: Told what happens; given in rank 0 only.
    """
    config, crops = prepared.config.train, prepared.crops
    module = PoseTraining(network, shape_tensors(prepared.config.objects), config, clock, crops)
    module.share = place.share
    average = MovingAverage(network, config.ema)
    together = [ActAsOne(clock, network.refiner, config.refiner_start)] if place.world > 1 else []
    trainer = _trainer(prepared, run, place, [average, *together, *observers])

    def reached(step: int) -> bool:
        return clock.fraction(step) >= (module.current_epoch + 1) / config.validations

    weights = sampling_weights(crops["train"].class_index, prepared.classes, config.balance)
    stream = BatchStream(len(crops["train"]), config.batch, config.seed, lambda: module.global_step, reached, weights)
    # A sequence of index tensors is a dataset to torch, whatever its base class.
    validation = cast(Dataset[torch.Tensor], torch.arange(len(crops["val"])).split(_VALIDATION_BATCH))
    train_loader, val_loader = DataLoader(stream, batch_size=None), DataLoader(validation, batch_size=None)
    clock.start_training()
    with writing(run):  # Checkpoints are all that Lightning writes.
        trainer.fit(module, train_loader, val_loader, ckpt_path=latest_checkpoint(run), weights_only=True)
    average.apply()
    return Fitted(trainer, module)


def latest_checkpoint(run: Path) -> Path | None:
    """Return the checkpoint that an interrupted run goes on from."""
    found = sorted((run / CHECKPOINTS).glob("*.ckpt"), key=lambda path: path.stat().st_mtime)
    return found[-1] if found else None


def _trainer(prepared: Prepared, run: Path, place: Place, callbacks: Sequence[lightning.Callback]) -> lightning.Trainer:
    config, on_gpu = prepared.config.train, torch.cuda.is_available()
    return lightning.Trainer(
        max_epochs=config.validations,
        accelerator="cuda" if on_gpu else "cpu",
        devices=place.world,
        # The refiner takes no part in the first steps' loss.
        strategy=DDPStrategy(find_unused_parameters=True, timeout=_PATIENCE) if place.world > 1 else "auto",
        plugins=[OneMachine(place)] if place.world > 1 else None,
        sync_batchnorm=on_gpu and place.world > 1,
        use_distributed_sampler=False,
        precision=choose_precision(config.precision),
        gradient_clip_val=config.clip_norm,
        callbacks=[*callbacks, ModelCheckpoint(run / CHECKPOINTS, filename="{step}")],
        # One pass over val before the first step tells how much time the last one needs.
        num_sanity_val_steps=-1,
        logger=False,  # What is worth keeping, the observers write.
        enable_progress_bar=False,
        enable_model_summary=False,
    )
