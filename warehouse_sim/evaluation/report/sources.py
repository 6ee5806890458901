"""What a report is made of: dataset, run and evaluation folders, recognised by what lies in them."""

import csv
import json
import logging
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.manifest import require_no_part
from warehouse_sim.dataset.reader import ALL, DatasetReader, is_dataset
from warehouse_sim.errors import ConfigError, DatasetError, EvaluationError, WarehouseSimError
from warehouse_sim.evaluation.scores import SCORES_FILE, Scores, read_scores
from warehouse_sim.yaml_file import read_yaml

log = logging.getLogger(__name__)
_RUN_CONFIG, _RUN_CURVES, _RUN_RESULT = "config.yaml", "curves.csv", "result.json"


@dataclass(frozen=True, eq=False)
class RunSource:
    """A training run, as far as a report shows it; read without what trains, which needs torch."""

    name: str
    """Name of the folder."""
    config: dict[str, Any]
    """The resolved settings."""
    curves: list[dict[str, float]]
    """One row a validation; empty cells are left out."""
    result: dict[str, Any]
    """What the run says of itself at its end; empty while it goes on."""


@dataclass(frozen=True, eq=False)
class EvaluationSource:
    """A score with the dataset that it was made on."""

    folder: Path
    scores: Scores
    data: DatasetReader


@dataclass(eq=False)
class Sources:
    """Everything found in the folders given, in their order."""

    datasets: dict[str, DatasetReader] = field(default_factory=dict)
    """By the hash of the manifest."""
    runs: list[RunSource] = field(default_factory=list)
    evaluations: list[EvaluationSource] = field(default_factory=list)


def read_sources(folders: Sequence[Path]) -> Sources:
    """Read dataset, run and evaluation folders, or folders that hold such folders.

    What cannot be read raises where it is named, and is left out with a warning where it only lies in such a folder.

    Raises:
        WarehouseSimError: A folder cannot be read or holds nothing to report, or an evaluation's dataset was not given.
    """
    named = [Path(os.path.realpath(folder)) for folder in folders]
    found = list(dict.fromkeys(path for folder in named for path in _recognised(folder)))
    sources = Sources()
    for add in (_add_data, _add_evaluation):  # in this order: an evaluation needs its dataset
        for path in found:
            try:
                add(sources, path)
            except WarehouseSimError as problem:
                if path in named:
                    raise
                log.warning("left out: %s", problem)
    if not (sources.datasets or sources.runs or sources.evaluations):
        raise EvaluationError(f"{named[0]}: nothing in it can be read; name one of the folders in it to see why")
    return sources


def _add_data(sources: Sources, path: Path) -> None:
    if is_dataset(path):
        reader = DatasetReader(path)
        reader.images(ALL)
        sources.datasets[reader.digest] = reader
    if (path / _RUN_CURVES).is_file():
        sources.runs.append(_read_run(path))


def _add_evaluation(sources: Sources, path: Path) -> None:
    if (path / SCORES_FILE).is_file():
        sources.evaluations.append(_read_evaluation(path, sources.datasets))


def _recognised(folder: Path) -> list[Path]:
    """Return a folder if it is a source, else the sources in it; warn of what looks like one and cannot be read.

    Raises:
        EvaluationError: It is no folder, or holds no source.
        DatasetError: It is an incomplete dataset, or holds nothing but what cannot be read.
    """
    if not folder.is_dir():
        raise EvaluationError(f"{folder}: is not a folder; give dataset, run and evaluation folders")
    known, problems = list[Path](), dict[Path, DatasetError]()
    for path in (folder, *sorted(path for path in folder.iterdir() if path.is_dir())):
        try:
            known += [path] if _is_known(path) else []
        except DatasetError as problem:
            problems[path] = problem
        if known == [folder]:
            return known
    require_no_part(folder)
    if problems and not known:
        raise next(iter(problems.values()))
    for path, reason in problems.items():
        if path != folder:  # which looks like bare images where one of those in it is
            log.warning("left out: %s", reason)
    if not known:
        raise EvaluationError(
            f"{folder}: holds no dataset (manifest.json), run ({_RUN_CURVES}) or evaluation ({SCORES_FILE}); "
            "give the folder that generate, train or evaluate wrote"
        )
    return known


def _is_known(path: Path) -> bool:
    """Return whether a folder is a source.

    Raises:
        DatasetError: It is an incomplete dataset, or images of which nothing says what the camera is.
    """
    if any(file.is_file() for file in (path / _RUN_CURVES, path / SCORES_FILE)) or is_dataset(path):
        return True
    require_no_part(path)
    return False


def _read_evaluation(path: Path, datasets: dict[str, DatasetReader]) -> EvaluationSource:
    scores = read_scores(path)
    digest = scores.dataset["manifest_sha256"]
    if digest not in datasets:
        raise EvaluationError(
            f"{path / SCORES_FILE}: was scored on a dataset ({scores.dataset['recipe']}, seed "
            f"{scores.dataset['seed']}) that is not among the folders given; give that dataset's folder too"
        )
    return EvaluationSource(path, scores, datasets[digest])


def _read_run(path: Path) -> RunSource:
    try:
        config = read_yaml(path / _RUN_CONFIG)
        curves = _read_curves(path / _RUN_CURVES)
        result_file = path / _RUN_RESULT
        text = result_file.read_text(encoding="utf-8") if result_file.exists() else "{}"
        result = json.loads(text, parse_constant=_reject_constant)
    except (OSError, ValueError, RecursionError, ConfigError) as problem:
        raise EvaluationError(f"{path}: the run cannot be read ({' '.join(str(problem).split())})") from problem
    if not isinstance(config, dict):
        raise EvaluationError(f"{path / _RUN_CONFIG}: expected a mapping of settings")
    if not isinstance(result, dict):
        raise EvaluationError(f"{path / _RUN_RESULT}: expected a mapping; go on with the run by train --resume")
    return RunSource(path.name, config, curves, result)


def _read_curves(path: Path) -> list[dict[str, float]]:
    """Return the rows of a table of numbers; empty cells are left out.

    Raises:
        ValueError: It is no whole table.
    """
    text = path.read_text(encoding="utf-8")
    names, *rows = csv.reader(text.splitlines()) if text else ([],)
    if not (names and text.endswith("\n") and all(map(str.isidentifier, names))):
        raise ValueError(f"{path.name} is empty or cut; go on with the run by train --resume")
    return [{name: float(cell) for name, cell in zip(names, row, strict=True) if cell} for row in rows]


def _reject_constant(constant: str) -> None:
    raise ValueError(f"{_RUN_RESULT}: {constant} is no number")
