"""The result of a suite as a file: estimators, data, and every number with its interval."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from warehouse_sim.benchmark.rows.row import Row
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.errors import ConfigError, DatasetError, EvaluationError
from warehouse_sim.output import make_folder

_FORMAT = 1


@dataclass(frozen=True)
class DataFacts:
    """A dataset that was scored."""

    name: str
    recipe: str
    """Empty for third-party data."""
    recipe_sha256: str
    """Of the resolved recipe with seed, scenes, formats and backend, its first digits; of others' data: of the labels.
    """
    seed: int | None
    scenes: int
    images: int
    ground_truths: int
    """Those that count: at least 10 % visible."""
    left_out_of_docking: dict[str, int] = field(default_factory=dict)
    """Pallets for which docking is not evaluated, by reason."""


@dataclass(frozen=True)
class EstimatorFacts:
    """Estimators that ran."""

    name: str
    trainings: int
    """How many are behind its numbers; 0 where nothing is trained."""
    weights_sha256: str = ""
    """First digits of the hash over all its weights; empty where there are none."""
    samples: int | None = None
    """Training samples that it saw, where the suite trained it."""


@dataclass(frozen=True)
class LeftOut:
    """What could not be scored, and why."""

    estimator: str
    condition: str
    reason: str


@dataclass(frozen=True)
class SuiteResult:
    """One run of a suite."""

    suite: str
    """Name and version."""
    question: str
    quick: bool
    """Whether it was made at the small sizes of --quick: intervals say what that is worth."""
    command: str
    """What makes it again."""
    machine: dict[str, Any]
    seconds: float
    """Wall time of this run; what was kept of runs before took none."""
    reused: int
    """Scores that were made by a run before, of inputs that are all the same."""
    data: tuple[DataFacts, ...]
    estimators: tuple[EstimatorFacts, ...]
    rows: tuple[Row, ...]
    left_out: tuple[LeftOut, ...] = ()
    notes: tuple[str, ...] = ()
    """What else a reader must know."""
    format: int = _FORMAT

    def __post_init__(self) -> None:
        if self.format != _FORMAT:
            raise ValueError(f"format must be {_FORMAT}, found {self.format}; run the suite again")
        known = {item.name for item in self.estimators}
        seen = set()
        for row in self.rows:
            low, high = row.interval
            where = f"{row.table}, {row.estimator}, {row.condition}, {row.group}, {row.metric}"
            if not low <= row.value <= high:
                raise ValueError(f"rows: {where}: {row.value} lies outside its interval {[low, high]}")
            if row.n < 1 or row.scenes < 1:
                raise ValueError(f"rows: {where}: n and scenes must be 1 or more, found {row.n} and {row.scenes}")
            if row.estimator not in known:
                raise ValueError(f"rows: {where}: the estimator is not among those that were evaluated")
            if where + row.against in seen:
                raise ValueError(f"rows: {where}: comes twice")
            seen.add(where + row.against)


def beside(stored: SuiteResult, new: SuiteResult) -> SuiteResult:
    """Return a new result with what a stored one says of estimators that did not run this time.

    It stays as it is where the stored one is of another suite, size, machine or data.
    """
    data = [_counted(old, now) for old, now in zip(stored.data, new.data, strict=False)]
    place = stored.suite, stored.quick, stored.machine, len(stored.data)
    if place != (new.suite, new.quick, new.machine, len(new.data)) or None in data:
        return new
    ran = {item.name for item in new.estimators} | {item.estimator for item in new.left_out}
    return replace(
        new,
        command="; ".join(dict.fromkeys((*stored.command.split("; "), new.command))),
        data=tuple(item for item in data if item),
        estimators=(*(item for item in stored.estimators if item.name not in ran), *new.estimators),
        rows=(*(row for row in stored.rows if not ran & {row.estimator, row.against}), *new.rows),
        left_out=(*(item for item in stored.left_out if item.estimator not in ran), *new.left_out),
        notes=tuple(dict.fromkeys((*stored.notes, *new.notes))),
    )


def _counted(stored: DataFacts, new: DataFacts) -> DataFacts | None:
    """Return the facts of one dataset with what was counted in it, which is nothing where nobody could be scored.

    None stands for two datasets.
    """
    if stored == new or stored == replace(new, ground_truths=0, left_out_of_docking={}):
        return new
    return stored if new == replace(stored, ground_truths=0, left_out_of_docking={}) else None


def write_result(result: SuiteResult, path: Path) -> Path:
    """Write a result and return its path."""
    make_folder(path.parent)
    write_json(path, to_mapping(result), depth=2)
    return path


def read_result(path: Path) -> SuiteResult:
    """Read a result, every field of it checked.

    Raises:
        EvaluationError: It is none, or one of its numbers cannot be.
    """
    try:
        return from_mapping(SuiteResult, read_json(path), str(path))
    except (ConfigError, DatasetError) as problem:
        raise EvaluationError(str(problem)) from problem
