"""From an estimator over its predictions to scores and a page that shows them."""

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir
from typing import Annotated, Any, Literal

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.dataset import Dataset, as_dataset
from warehouse_sim.api.estimates import Estimator, chosen_split, estimates_of, method_name, scores_of
from warehouse_sim.dataset.results import predictions as prediction_file
from warehouse_sim.errors import InputError
from warehouse_sim.evaluation import Scores, write_scores
from warehouse_sim.learning.settings import Progress
from warehouse_sim.optional import require_extra
from warehouse_sim.output import writing
from warehouse_sim.ranges import Range
from warehouse_sim.schema import PoseEstimate

Frames = Annotated[int, Range(1, 1_000_000)]


@checked
def predict(
    estimator: Estimator,
    data: Dataset | str | Path,
    out: str | Path | None = None,
    split: str | None = None,
    pictures: str | Path | None = None,
    progress: Progress | None = None,
    command: str = "",
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
        command: The command line that requests it, to be kept beside ``out`` with the estimator's name.
        settings: Settings by name, as the options of ``warehouse-sim predict``: ``detections="detector-rgb"``,
            ``refine="icp"``, ``seed=1``, ...

    Returns:
        One estimate for each object that was found, in the order of the images.

    Raises:
        UnknownNameError: No estimator has that name.
        DatasetError: The folder is no dataset, or has no such split.
    """
    require_extra("learn", "to predict")
    opened = as_dataset(data)
    estimates = estimates_of(opened, estimator, chosen_split(opened, split), settings, progress, pictures)
    if out is not None:
        refined = f"+{settings['refine']}" if settings.get("refine") not in (None, "none") else ""
        prediction_file.write(
            Path(out), estimates, prediction_file.Origin(f"{method_name(estimator)}{refined}", command)
        )
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
    return scores_of(opened, predictions, chosen_split(opened, split), out, bop, vsd, method)


@checked
def report(
    *sources: Dataset | Scores | str | Path, out: str | Path = "report.html", frames: Frames | Literal["all"] = 300
) -> Path:
    """Write one HTML page about datasets, runs and scores, or about suites; it needs no other file.

    Example:
        >>> data = ws.Dataset("out")
        >>> page = ws.report(data, data.evaluate(lambda image: []), out="report.html")
        >>> page.name
        'report.html'

    Args:
        sources: Datasets, scores, or folders of datasets, training runs and scores; scores need their dataset among
            them. Or results of suites alone, as ``warehouse-sim bench`` writes them, and folders of these.
        out: The page to write; of suites, a name that ends in .md takes the leaderboards alone, as Markdown.
        frames: How many frames of datasets are shown at most; of more, the worst by each filter and a sample, or "all".

    Returns:
        The path of the page.

    Raises:
        EvaluationError: A folder holds nothing to report, or a dataset is missing.
        MissingPackageError: plotly or jinja2 is not installed.
    """
    require_extra("report", "to write a report")
    from warehouse_sim.benchmark.report import is_results, write_suite_report
    from warehouse_sim.evaluation.report import write_report

    if not sources:
        raise InputError("report needs at least one dataset, run folder or scores")
    suites = [Path(item) for item in sources if isinstance(item, (str, Path)) and is_results(Path(item))]
    other = next((item for item in sources if not isinstance(item, (str, Path)) or Path(item) not in suites), None)
    if suites and other is not None:
        raise InputError(
            f"{other}: holds no results of suites, as others of the paths do; give those to a page of their own"
        )
    endings = (".html", ".htm", *([".md"] if suites else []))
    if Path(out).suffix.lower() not in ("", *endings):
        raise InputError(f"{out}: is written as {' or '.join(endings)}; give it a name that ends so")
    if suites:
        return write_suite_report(suites, Path(out))
    with ExitStack() as kept:
        folders: list[Path] = []
        for item in sources:
            if isinstance(item, Scores):
                with writing(Path(gettempdir())):
                    folder = Path(kept.enter_context(TemporaryDirectory())) / Path(item.method).name
                write_scores(item, folder)
            else:
                folder = item.scored.root if isinstance(item, Dataset) else Path(item)
            folders.append(folder)
        return write_report(list(dict.fromkeys(folders)), out, None if frames == "all" else frames)
