"""The predictions that are scored: a file, or estimates in memory."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.dataset.results import predictions as prediction_file
from warehouse_sim.dataset.results.pose_csv import require_estimates
from warehouse_sim.schema import PoseEstimate


@dataclass(frozen=True, eq=False)
class ScoredEstimates:
    """Estimates, and how messages name them."""

    estimates: tuple[PoseEstimate, ...]
    """Those that are not rejected."""
    rejected: int
    """How many are."""
    name: str
    """The file, or what stands for it."""
    method: str
    """The file's name up to the first underscore (the BOP rule)."""
    is_file: bool

    @classmethod
    def of(cls, predictions: str | Path | Sequence[PoseEstimate]) -> "ScoredEstimates":
        """Read a file of predictions, or take estimates.

        Raises:
            DatasetError: The file cannot be read.
            InputError: Something in the list is no estimate.
        """
        if isinstance(predictions, (str, Path)):
            path = Path(predictions)
            found = tuple(prediction_file.read(path))
            return cls(found, prediction_file.count_rejected(path), str(path), path.stem.split("_")[0], True)
        estimates = require_estimates(predictions, "the predictions")
        kept = tuple(item for item in estimates if not item.rejected)
        return cls(kept, len(estimates) - len(kept), "the estimates", "estimates", False)

    def place(self, number: int) -> str:
        """Return how messages name one estimate by its position."""
        return f"{self.name}: line {number + 2}" if self.is_file else f"estimate {number}"
