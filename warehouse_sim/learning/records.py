"""Observers that write the curves and the diary of a run and report its progress."""

import csv
import math
import time
from datetime import UTC, datetime
from pathlib import Path

from tensorboardX.proto.event_pb2 import Event
from tensorboardX.proto.summary_pb2 import Summary
from tensorboardX.record_writer import RecordWriter

from warehouse_sim.learning.observer import Observer, TrainingState
from warehouse_sim.learning.settings import Progress
from warehouse_sim.output import make_folder, writing


class EventFile:
    """One file of events.

    Args:
        path: The file to make; its folder must exist.

    Raises:
        OutputError: It cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        with writing(path):
            self._records = RecordWriter(str(path))
        self._append(Event(wall_time=time.time(), file_version="brain.Event:2"))

    def write(self, values: dict[str, float], step: int) -> None:
        """Append the values of one step, by tag.

        Raises:
            OutputError: They cannot be written.
        """
        summary = Summary(value=[Summary.Value(tag=tag, simple_value=value) for tag, value in values.items()])
        self._append(Event(wall_time=time.time(), step=step, summary=summary))

    def _append(self, event: Event) -> None:
        with writing(self._path):
            self._records.write(event.SerializeToString())
            self._records.flush()


class RunLog(Observer):
    """Append lines to a text file; as an observer, also one after each validation.

    Args:
        path: The file; lines of an earlier session of the run stay.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def note(self, message: str) -> None:
        """Write one line with the time (UTC) before it."""
        with writing(self._path), self._path.open("a", encoding="utf-8") as file:
            file.write(f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S}Z  {message}\n")

    def on_validation(self, state: TrainingState) -> None:
        """Write where the run stands."""
        values = ", ".join(f"{name} {value:.1f}" for name, value in state.metrics.items())
        self.note(f"step {state.step}, loss {state.loss:.4f}, {values}")


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
