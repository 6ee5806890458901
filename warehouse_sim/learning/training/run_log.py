"""The diary of a run: one dated line for each thing that happened, over all its sessions."""

from datetime import UTC, datetime
from pathlib import Path

import lightning

from warehouse_sim.learning.training.module import PoseTraining
from warehouse_sim.output import writing


class RunLog(lightning.Callback):
    """Append lines to a text file; as a callback, also one after each validation.

    Args:
        path: The file; lines of an earlier session of the run stay.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def note(self, message: str) -> None:
        """Write one line with the time (UTC) before it."""
        with writing(self._path), self._path.open("a", encoding="utf-8") as file:
            file.write(f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S}Z  {message}\n")

    def on_validation_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        """Write where the run stands."""
        assert isinstance(pl_module, PoseTraining)
        values = ", ".join(f"{name} {value:.1f}" for name, value in pl_module.metrics.items())
        self.note(f"step {trainer.global_step}, loss {pl_module.train_loss:.4f}, {values}")
