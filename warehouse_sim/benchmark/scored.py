"""Predictions and scores of each entrant under each condition, kept, and regenerated only where inputs differ."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from warehouse_sim.benchmark.entrants.entrant import Entrant, Group, Request, ResultFile
from warehouse_sim.benchmark.groups import EdgeConfig, Subjects
from warehouse_sim.benchmark.kept import file_digest, folder_for, is_kept, keep
from warehouse_sim.benchmark.machine import machine_text
from warehouse_sim.benchmark.sets import MadeSet
from warehouse_sim.benchmark.suite import ConditionConfig
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import predictions
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation import Scores, evaluate, read_scores, write_scores
from warehouse_sim.evaluation.scores import SCORES_FORMAT, SETTINGS
from warehouse_sim.output import make_folder, write_bytes

SPLITS = ("test", "val", "train")
"""Of third-party folders the first that has poses is scored; of a suite's own data all is test."""
Fraction = Callable[[float, str], None]
_CSV = "predictions.csv"
_MACHINE = "machine.txt"
"""Beside predictions that were made here: the machine that times were measured on."""


@dataclass(frozen=True, eq=False)
class Opened:
    """A dataset of a suite, read."""

    made: MadeSet
    reader: DatasetReader
    points: dict[tuple[int, int, int], int]
    """LiDAR points on each ground truth, where a grouping requires them."""
    split: str = SPLITS[0]
    """Which is scored."""

    @property
    def variants(self) -> tuple[str, ...]:
        """Name of the variant of each observation of a scene; empty without paired variants."""
        manifest = self.reader.manifest
        return () if manifest is None else tuple(item.variant for item in manifest.paired_variants)

    @property
    def groups(self) -> tuple[int, ...]:
        """Number of the paired variant group of each observation of a scene; empty without paired variants."""
        manifest = self.reader.manifest
        return () if manifest is None else tuple(item.group for item in manifest.paired_variants)


def posed_split(reader: DatasetReader) -> str:
    """Return the first split of ``SPLITS`` that has poses; empty where none has."""
    for split in (name for name in SPLITS if name in reader.splits):
        if any(target.has_pose for image in reader.images(split) for target in image.targets):
            return split
    return ""


@dataclass(frozen=True, eq=False)
class Answer:
    """What an entrant was worth under a condition, by each of its trainings."""

    group: Group
    condition: str
    opened: Opened
    scores: tuple[Scores, ...]
    machine: str = ""
    """That predicted; empty where nobody stated it."""

    def subjects(self, edges: EdgeConfig) -> Subjects:
        """Return the ground truths, the same for all trainings."""
        return Subjects(self.scores[0].table, edges, self.opened.variants, self.opened.points)


def scored(
    member: Entrant,
    condition: ConditionConfig,
    opened: Opened,
    out: Path,
    overwrite: bool = False,
    progress: Fraction = lambda fraction, note: None,
) -> tuple[Scores, bool]:
    """Return the scores of an entrant under a condition, and whether they were made before.

    Args:
        member: Who answers.
        condition: What is evaluated.
        opened: The data.
        out: Folder of the benchmark.
        overwrite: Make predictions and scores again, whatever is kept.
        progress: Called with the fraction of the images that is done.
    """
    place, inputs = _of_predictions(member, condition, opened, out)
    csv = place / _CSV
    if overwrite or not is_kept(place, inputs):
        estimates = member.estimates(Request(opened.reader, opened.split, condition, progress, out))
        make_folder(place)
        predictions.write(csv, estimates)
        if not isinstance(member, ResultFile):
            write_bytes(place / _MACHINE, machine_text().encode())
        keep(place, inputs)
    place, inputs = _of_scores(member.name, csv, opened, out)
    if not overwrite and is_kept(place, inputs):
        with suppress(EvaluationError):
            return read_scores(place), True
    write_scores(evaluate(csv, opened.made.root, opened.split, method=member.name), place)
    keep(place, inputs)
    return read_scores(place), False  # the same numbers as when they are read again


def machine_of(member: Entrant, condition: ConditionConfig, opened: Opened, out: Path) -> str:
    """Return processor and cores that kept predictions were made on; empty where that was not stated."""
    path = _of_predictions(member, condition, opened, out)[0] / _MACHINE
    return path.read_text(encoding="utf-8") if path.is_file() else ""


def is_scored(member: Entrant, condition: ConditionConfig, opened: Opened, out: Path) -> bool:
    """Return whether the scores of an entrant under a condition were made before."""
    place, inputs = _of_predictions(member, condition, opened, out)
    return is_kept(place, inputs) and is_kept(*_of_scores(member.name, place / _CSV, opened, out))


def _of_predictions(
    member: Entrant, condition: ConditionConfig, opened: Opened, out: Path
) -> tuple[Path, dict[str, Any]]:
    """Return where predictions are kept, and what they are made of."""
    inputs = member.inputs(condition) | {"data": opened.reader.digest, "split": opened.split}
    return folder_for(out / "predictions" / opened.made.root.resolve().name, member.name, inputs), inputs


def _of_scores(name: str, csv: Path, opened: Opened, out: Path) -> tuple[Path, dict[str, Any]]:
    """Return where scores of predictions are kept, and what they are made of."""
    beside = predictions.uncertainty_file(csv)
    inputs = {
        "predictions": file_digest(csv),
        "uncertainty": file_digest(beside) if beside.is_file() else "",
        "data": opened.reader.digest,
        "settings": SETTINGS,
        "format": SCORES_FORMAT,
    }
    return folder_for(out / "scores" / opened.made.root.resolve().name, name, inputs), inputs
