"""From an estimator over its predictions to scores and a page that shows them."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.dataset import Dataset, as_dataset
from warehouse_sim.api.settings import settings_of
from warehouse_sim.dataset.reader import ALL
from warehouse_sim.dataset.results import predictions as prediction_file
from warehouse_sim.errors import DatasetError, InputError
from warehouse_sim.evaluation import Scores, write_scores
from warehouse_sim.evaluation import evaluate as score
from warehouse_sim.optional import require_extra
from warehouse_sim.schema import PoseEstimate

_TEST = "test"
Estimator = str | Path | Callable[..., Any] | object
"""A name, a run folder, "file.py:Class", "module:Class", an object with ``estimate(image)``, or a function."""


@checked
def predict(
    estimator: Estimator,
    data: Dataset | str | Path,
    out: str | Path | None = None,
    split: str | None = None,
    pictures: str | Path | None = None,
    progress: Callable[[float, str], None] | None = None,
    **settings: Any,
) -> list[PoseEstimate]:
    """Estimate the poses of a split.

    Example:
        >>> def guess(image):
        ...     return []
        >>> estimates = ws.predict(guess, "out", "guess.csv")
        >>> len(estimates)
        0

    Args:
        estimator: A name, a run folder, "file.py:Class", "module:Class", an object with ``estimate(image)``, or a
            function that takes an ``RgbdImage`` and returns a list of ``PoseEstimate``.
        data: The dataset.
        out: File to write, in the BOP pose CSV, with covariances and bounds beside it; none by default.
        split: A split or "all"; by default test, or all that is there where test is empty.
        pictures: Folder for a picture of each image with the poses in it; none by default.
        progress: Called with the fraction that is done and a note.
        settings: Settings by name, as the options of ``warehouse-sim predict``: ``detections="detector-rgb"``,
            ``refine="icp"``, ``seed=1``, ...

    Returns:
        One estimate for each object that was found, in the order of the images.

    Raises:
        UnknownNameError: No estimator has that name.
        DatasetError: The folder is no dataset, or has no such split.
    """
    require_extra("learn", "to predict")
    from warehouse_sim.estimators.predict import predict as estimate
    from warehouse_sim.estimators.settings import PredictConfig

    opened = as_dataset(data)
    config = settings_of(PredictConfig(), settings, "predict")
    estimates = estimate(estimator, opened.scored, named_split(opened, split), config, progress, pictures)
    if out is not None:
        prediction_file.write(Path(out), estimates)
    return estimates


@checked
def evaluate(
    predictions: str | Path | Sequence[PoseEstimate],
    data: Dataset | str | Path,
    split: str | None = None,
    out: str | Path | None = None,
    bop: bool = False,
    vsd: bool = False,
    method: str | None = None,
) -> Scores:
    """Score predictions against the ground truth of a split; an object without an estimate counts as missed.

    Example:
        >>> data = ws.Dataset("out")
        >>> scores = ws.evaluate(ws.predict(lambda image: [], data), data)
        >>> scores["overall"]["metrics"]["add_10pct"], scores.metrics["add_10pct"]
        (0.0, 0.0)

    Args:
        predictions: A file in the BOP pose CSV, or what ``predict`` returned.
        data: The dataset.
        split: A split or "all"; by default test, or all that is there where test is empty.
        out: Folder for ``scores.json``, ``errors.csv`` and ``predictions.csv``, which ``report`` takes; none if None.
        bop: Whether the scores of the BOP challenges are added.
        vsd: Whether these have the recall by VSD, too.
        method: Name in the scores; by default from the name of the file.

    Raises:
        EvaluationError: An estimate names an image or object that the split lacks, or nothing can be scored.
        DatasetError: The dataset or the file cannot be read.
    """
    opened = as_dataset(data)
    if out is not None and Path(out).resolve() == opened.path.resolve():
        raise InputError(f"{out} is the folder of the dataset; name another one for the scores")
    scores = score(predictions, opened.scored, named_split(opened, split), None, method, bop, vsd)
    if out is not None:
        write_scores(scores, out)
    return scores


@checked
def report(*sources: Dataset | Scores | str | Path, out: str | Path = "report.html") -> Path:
    """Write one HTML page about datasets, runs and scores, which needs no other file.

    Example:
        >>> data = ws.Dataset("out")
        >>> page = ws.report(data, data.evaluate(lambda image: []), out="report.html")
        >>> page.name
        'report.html'

    Args:
        sources: Datasets, scores, or folders of datasets, training runs and scores; scores need their dataset among
            them.
        out: The page to write.

    Returns:
        The path of the page.

    Raises:
        EvaluationError: A folder holds nothing to report, or a dataset is missing.
        MissingPackageError: matplotlib or jinja2 is not installed.
    """
    require_extra("report", "to write a report")
    from warehouse_sim.evaluation.report import write_report

    if not sources:
        raise InputError("report needs at least one dataset, run folder or scores")
    with TemporaryDirectory() as place:
        folders: list[Path] = []
        for number, item in enumerate(sources):
            if isinstance(item, Scores):
                folder = Path(place) / f"{number}_{item.method}"
                write_scores(item, folder)
            else:
                folder = item.scored.root if isinstance(item, Dataset) else Path(item)
            folders.append(folder)
        return write_report(list(dict.fromkeys(folders)), out)


def predict_and_score(
    estimator: Estimator,
    data: Dataset,
    split: str | None,
    out: str | Path | None,
    bop: bool,
    vsd: bool,
    settings: Mapping[str, Any],
) -> Scores:
    """Do what ``Dataset.evaluate`` says."""
    chosen = named_split(data, split)
    estimates = predict(estimator, data, split=chosen, **settings)
    return evaluate(estimates, data, chosen, out, bop, vsd, method_name(estimator))


def named_split(data: Dataset, split: str | None) -> str:
    """Return the split that is meant: without a name the only one, or test, or all where test is empty.

    Raises:
        DatasetError: There is no such split, or no observation in it.
    """
    if split is not None:
        chosen = data if split == ALL else data.split(split)
        if not len(chosen):
            raise DatasetError(f"{data.path}: the split {split!r} has no observations; choose another, or split='all'")
        return split
    found = list(dict.fromkeys(obs.split for obs in data))
    if not found:
        raise DatasetError(f"{data.path}: there is no observation to look at")
    return found[0] if len(found) == 1 else _TEST if _TEST in found else ALL


def method_name(estimator: Estimator) -> str:
    """Return how scores name an estimator: its name, the last part of its path, or its function or class."""
    if isinstance(estimator, (str, Path)):
        return Path(str(estimator).rpartition(":")[2] or str(estimator)).name
    return str(getattr(estimator, "__name__", type(estimator).__name__)).strip("<>")
