"""Observers that write the curves of a run and report its progress."""

import csv
import math
import time
from pathlib import Path

from warehouse_sim.learning.event_file import EventFile
from warehouse_sim.learning.observer import Observer, TrainingState
from warehouse_sim.learning.progress import Progress
from warehouse_sim.output import make_folder, writing


class CurveWriter(Observer):
    """Append a row to a CSV file after each validation.

    Args:
        path: The file; rows of an earlier session of the run stay.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def on_validation(self, state: TrainingState) -> None:
        """Write step, seconds, learning rate, training loss and the validation's metrics."""
        row = {
            "step": state.step,
            "samples": state.step * state.config.batch,
            "seconds": round(state.clock.spent(), 2),
            "learning_rate": state.learning_rate,
            "train_loss": "" if math.isnan(state.loss) else round(state.loss, 6),
            **{name: round(value, 3) for name, value in state.metrics.items()},
        }
        new = not self._path.exists()
        with writing(self._path), self._path.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(row))
            if new:
                writer.writeheader()
            writer.writerow(row)


class EventWriter(Observer):
    """Write the same values, and the training loss in between, as TensorBoard events.

    Args:
        folder: Where each session of the run has a file.
        every: Steps between two values of the training loss, >= 2.
    """

    def __init__(self, folder: Path, every: int = 20) -> None:
        make_folder(folder)
        self._file = EventFile(folder / f"events.out.tfevents.{time.time_ns()}")
        self._every = every

    def on_step(self, state: TrainingState) -> None:
        """Write loss and learning rate at the first step and now and then."""
        if state.step % self._every == 1:
            self._file.write({"train/loss": state.loss, "train/learning_rate": state.learning_rate}, state.step)

    def on_validation(self, state: TrainingState) -> None:
        """Write the validation's metrics."""
        self._file.write({name.replace("_", "/", 1): value for name, value in state.metrics.items()}, state.step)


class ProgressReporter(Observer):
    """Pass the progress of a run on after each step.

    Args:
        report: Where it goes.
        metric: Which of the last validation's metrics is reported.
        words: How it is reported: the metric's value stands for {}.
    """

    def __init__(self, report: Progress, metric: str, words: str) -> None:
        self._report, self._metric, self._words = report, metric, words

    def on_step(self, state: TrainingState) -> None:
        """Report share and loss, and the last validation's success."""
        note = f"step {state.step}, loss {state.loss:.3f}"
        if self._metric in state.metrics:
            note += f", {self._words.format(state.metrics[self._metric])}"
        self._report(state.fraction, note)
