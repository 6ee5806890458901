"""The diary of a run: one dated line for each thing that happened, over all its sessions."""

from datetime import UTC, datetime
from pathlib import Path

from warehouse_sim.learning.observer import Observer, TrainingState
from warehouse_sim.output import writing


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
