"""Callbacks that write the curves of a run and tell how far it is."""

import csv
import math
import time
from pathlib import Path

import lightning

from warehouse_sim.learning.progress import Progress
from warehouse_sim.learning.training.event_file import EventFile
from warehouse_sim.learning.training.module import PoseTraining
from warehouse_sim.output import make_folder, writing


class CurveWriter(lightning.Callback):
    """Append a row to a CSV file after each validation.

    Args:
        path: The file; rows of an earlier session of the run stay.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def on_validation_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        """Write step, seconds, learning rate, training loss and the validation's metrics."""
        if trainer.sanity_checking:
            return
        assert isinstance(pl_module, PoseTraining)
        row = {
            "step": trainer.global_step,
            "samples": trainer.global_step * pl_module.config.batch,
            "seconds": round(pl_module.clock.spent(), 2),
            "learning_rate": trainer.optimizers[0].param_groups[0]["lr"],
            "train_loss": "" if math.isnan(pl_module.train_loss) else round(pl_module.train_loss, 6),
            **{name: round(value, 3) for name, value in pl_module.metrics.items()},
        }
        new = not self._path.exists()
        with writing(self._path), self._path.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(row))
            if new:
                writer.writeheader()
            writer.writerow(row)


class EventWriter(lightning.Callback):
    """Write the same values, and the training loss in between, as TensorBoard events.

    Args:
        folder: Where each session of the run has a file.
        every: Steps between two values of the training loss, >= 2.
    """

    def __init__(self, folder: Path, every: int = 20) -> None:
        make_folder(folder)
        self._file = EventFile(folder / f"events.out.tfevents.{time.time_ns()}")
        self._every = every

    def on_train_batch_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule, *_: object) -> None:
        """Write loss and learning rate at the first step and now and then."""
        assert isinstance(pl_module, PoseTraining)
        if trainer.global_step % self._every == 1:
            rate = trainer.optimizers[0].param_groups[0]["lr"]
            self._file.write({"train/loss": pl_module.train_loss, "train/learning_rate": rate}, trainer.global_step)

    def on_validation_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        """Write the validation's metrics."""
        assert isinstance(pl_module, PoseTraining)
        if not trainer.sanity_checking:
            values = {name.replace("_", "/", 1): value for name, value in pl_module.metrics.items()}
            self._file.write(values, trainer.global_step)


class ProgressReporter(lightning.Callback):
    """Pass the progress of a run on after each step.

    Args:
        report: Where it goes.
    """

    def __init__(self, report: Progress) -> None:
        self._report = report

    def on_train_batch_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule, *_: object) -> None:
        """Report share and loss, and the last validation's accuracy."""
        assert isinstance(pl_module, PoseTraining)
        note = f"step {trainer.global_step}, loss {pl_module.train_loss:.3f}"
        if pl_module.metrics:
            note += f", validation within 5 % of diameter {pl_module.metrics['val_within_5_percent']:.1f} %"
        self._report(pl_module.clock.fraction(trainer.global_step), note)
