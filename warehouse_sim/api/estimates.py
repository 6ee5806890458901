"""Estimates for a split of an open dataset, and their scores.

The stages are imported when they are used, so that to open a dataset loads neither torch nor what scores.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from warehouse_sim.api.arguments import settings_of
from warehouse_sim.dataset.reader import ALL, DatasetReader
from warehouse_sim.dataset.split import require_split
from warehouse_sim.errors import DatasetError, InputError
from warehouse_sim.learning.settings import Progress
from warehouse_sim.optional import require_extra
from warehouse_sim.schema import PoseEstimate

if TYPE_CHECKING:
    from warehouse_sim.evaluation import Scores

_TEST = "test"
Estimator = str | Path | Callable[..., Any] | object
"""A name, a run folder, "file.py:Class", "module:Class", an object with ``estimate(image)``, or a function."""


class Opened(Protocol):
    """A dataset that is open, or a part of one."""

    path: Path
    """Its folder."""

    @property
    def scored(self) -> DatasetReader:
        """Its observations alone."""
        ...


def chosen_split(data: Opened, split: str | None) -> str:
    """Return the split that is meant: without a name the only one, or test, or all where test is empty.

    Raises:
        DatasetError: There is no such split, or none is named and there is no observation.
    """
    if split is not None:
        if split != ALL:
            require_split(data.path, split, data.scored.splits)
        return split
    reader = data.scored
    found = [name for name in reader.parts if reader.images(name)]
    if not found:
        raise DatasetError(f"{data.path}: there is no observation to look at")
    return found[0] if len(found) == 1 else _TEST if _TEST in found else ALL


def estimates_of(
    data: Opened,
    estimator: Estimator,
    split: str,
    settings: Mapping[str, Any],
    progress: Progress | None = None,
    pictures: str | Path | None = None,
) -> list[PoseEstimate]:
    """Do what ``predict`` says, for a split that there is."""
    require_extra("learn", "to predict")
    from warehouse_sim.estimators.predict import predict
    from warehouse_sim.estimators.settings import PredictConfig

    return predict(estimator, data.scored, split, settings_of(PredictConfig(), settings, "predict"), progress, pictures)


def scores_of(
    data: Opened,
    predictions: str | Path | Sequence[PoseEstimate],
    split: str,
    out: str | Path | None,
    bop: bool,
    vsd: bool,
    method: str | None,
) -> "Scores":
    """Do what ``evaluate`` says, for a split that there is."""
    from warehouse_sim.evaluation import evaluate, write_scores

    if out is not None and Path(out).resolve() == data.path.resolve():
        raise InputError(f"{out} is the folder of the dataset; name another one for the scores")
    scores = evaluate(predictions, data.scored, split, method, bop, vsd)
    if out is not None:
        write_scores(scores, out)
    return scores


def method_name(estimator: Estimator) -> str:
    """Return how scores name an estimator: its name, the last part of its path, or its function or class."""
    if isinstance(estimator, (str, Path)):
        return Path(str(estimator).rpartition(":")[2] or str(estimator)).name
    return str(getattr(estimator, "__name__", type(estimator).__name__)).strip("<>")
