"""What an estimator is worth on one split of one dataset, and the folder that keeps it."""

from dataclasses import asdict, dataclass, field, fields
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.files.record import Record
from warehouse_sim.dataset.results import predictions
from warehouse_sim.errors import DatasetError, EvaluationError, UnknownNameError
from warehouse_sim.evaluation.bop_scores import BopScores
from warehouse_sim.evaluation.docking.fork import FORK
from warehouse_sim.evaluation.error_table import ErrorTable, read_table, write_table
from warehouse_sim.evaluation.measuring import MIN_MODEL_POINTS, MIN_VISIBLE
from warehouse_sim.evaluation.summary import (
    DIAMETER_PERCENT,
    DISTANCE_EDGES,
    DOCKING_MARGIN_MM,
    ILLUMINANCE_EDGES,
    RESAMPLES,
    RESAMPLING_SEED,
    VISIBLE_FRACTION_EDGES,
    Summary,
)
from warehouse_sim.evaluation.trust import Trust
from warehouse_sim.output import make_folder
from warehouse_sim.ranges import Range
from warehouse_sim.schema import PoseEstimate

SCORES_FILE, ERRORS_FILE, PREDICTIONS_FILE = "scores.json", "errors.csv", "predictions.csv"
SCORES_FORMAT = 6
"""Counts up when a number of scores.json means something else."""
WITHOUT_CAD = {"model": "cloud of the instance", "diameter": "box diagonal"}
"""What scores say of a dataset without CAD: what errors are measured on, and what fractions of the diameter mean."""

WITHOUT_ACCESSIBILITY = {"evaluated": "all pallets, as not all say which a truck can reach"}
"""What scores say of a dataset made by others: docking is evaluated of more than a truck can do."""


SETTINGS: dict[str, Any] = {
    "measure": {"min_visible_fraction": MIN_VISIBLE, "min_model_points": MIN_MODEL_POINTS, "fork": FORK},
    "metrics": {"diameter_percent": list(DIAMETER_PERCENT), "docking_margin_mm": list(DOCKING_MARGIN_MM)},
    "groups": {
        "distance_edges": list(DISTANCE_EDGES),
        "visible_fraction_edges": list(VISIBLE_FRACTION_EDGES),
        "illuminance_edges": list(ILLUMINANCE_EDGES),
        "bootstrap_resamples": RESAMPLES,
        "bootstrap_seed": RESAMPLING_SEED,
    },
}
"""What decides a score besides predictions and data, as scores.json states it."""


Count = Annotated[int, Range(0, 2**63 - 1)]


@dataclass(frozen=True, eq=False)
class ScoresFile(Record):
    """What scores.json holds."""

    method: str
    """Name of the method: of what predicted, or else from the name of its predictions file."""
    dataset: dict[str, Any]
    """Recipe, seed, scenes, split and hash of the manifest; ``WITHOUT_CAD`` and ``WITHOUT_ACCESSIBILITY`` if true."""
    settings: dict[str, Any]
    """``SETTINGS``."""
    counts: dict[str, Count]
    """Scenes, images, ground truths that count and that do not, predictions, found, rejected."""
    overall: Summary
    """All ground truths."""
    groups: dict[str, tuple[Summary, ...]]
    """The same metrics by class, object, distance, visible fraction and light."""
    docking_failures: dict[str, Count]
    """Of the ground truths that cannot be docked with no margin: how many by the error to blame."""
    docking_left_out: dict[str, Count]
    """Ground truths with pockets for which docking is not evaluated, by reason; "no clearance for 20 mm" is of that
    margin."""
    trust: Trust
    """What scores, bounds and rejections are worth."""
    seconds_per_image: Annotated[float, Range(-1e15, 1e15, "s")] | None
    """Mean time of the estimator, where the predictions hold it."""
    bop: BopScores | None = field(default=None, metadata={"omitted": True})
    """The scores of the BOP challenges, where they were requested."""
    predicted_by: str = field(default="", metadata={"omitted": True})
    """The command that made the predictions, where they say so."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Scores(ScoresFile):
    """The numbers, the groups behind them, and the rows behind those.

    It reads like the mapping in scores.json, too: ``scores["overall"]["metrics"]["add_10pct"]``.
    """

    table: ErrorTable
    """One row a ground truth; errors.csv beside scores.json."""
    estimates: tuple[PoseEstimate, ...]
    """What was scored; predictions.csv beside scores.json."""

    def __repr__(self) -> str:
        return "\n".join(self.summary())

    def __getitem__(self, key: str) -> Any:
        """Return an entry of scores.json.

        Raises:
            UnknownNameError: There is no such entry.
        """
        entries = self.to_plain()
        if not isinstance(key, str) or key not in entries:
            raise UnknownNameError("entry of the scores", str(key), list(entries))
        return entries[key]

    @property
    def metrics(self) -> dict[str, float]:
        """The metrics over all ground truths: ``add_10pct``, ``pose_5cm_5deg``, ``dock_0mm``, ..."""
        return self.overall.metrics

    def to_plain(self) -> dict[str, Any]:
        """Return the content of scores.json."""
        stated = ScoresFile(**{item.name: getattr(self, item.name) for item in fields(ScoresFile)})
        return {"format": SCORES_FORMAT, **stated.row()}

    def summary(self) -> list[str]:
        """Return the lines that a person wants to read first."""
        metrics, counts = self.overall.metrics, self.counts
        middle = metrics["median_add"]
        median = f"median {100 * middle:.2f} cm" if isfinite(middle) else "no median: half or more are missed"
        accuracy = [f"{100 * metrics[f'add_{k}pct']:.1f} % under {k} % d" for k in DIAMETER_PERCENT]
        words = ", ".join(f"{key}: {self.dataset[key]}" for key in reversed(WITHOUT_CAD) if key in self.dataset)
        docking = [f"{100 * metrics[f'dock_{k}mm']:.1f} % with {k} mm" for k in DOCKING_MARGIN_MM]
        lines = [
            f"{self.method} on {self.dataset['recipe']} {self.dataset['split']}: "
            f"{counts['found']} of {counts['ground_truths']} objects found in {counts['images']} images",
            f"ADD:     {', '.join(accuracy)}, {median}",
            f"5cm5deg: {100 * metrics['pose_5cm_5deg']:.1f} %",
        ]
        lines += [words] if words else []
        if self.bop is not None:
            known = {name: value for name, value in asdict(self.bop).items() if value is not None}
            fractions = {name: f"{100 * value:.1f} %" for name, value in known.items()}
            lines.append(
                f"BOP:     AR {fractions['ar_mssd']} by MSSD, {fractions['ar_mspd']} by MSPD; AP {fractions['ap']} "
                f"({fractions['ap_mssd']} by MSSD, {fractions['ap_mspd']} by MSPD), "
                f"{fractions['ap_mssd_mm']} by MSSD of 2 to 20 mm"
            )
            if "ar_vsd" in fractions:
                lines.append(f"         AR {fractions['ar_vsd']} by VSD, {fractions['ar']} the mean of the three")
        if self.trust.bound:
            lines.append(
                f"trust:   {self.trust.failures} of {self.trust.estimates} wrong, AUROC {self.trust.auroc:.3f}, "
                f"bound holds for {100 * self.trust.bound[0].fraction:.0f} %, {self.counts.get('rejected', 0)} rejected"
            )
        if self.overall.dockable_count:
            lines.append(f"docking: {', '.join(docking)} of clearance")
            nominal = [f"{100 * metrics[f'dock_nominal_{k}mm']:.1f} %" for k in DOCKING_MARGIN_MM]
            lines.append(f"         by nominal pockets: {', '.join(nominal)}")
        return lines + self._left_out_lines()

    def _left_out_lines(self) -> list[str]:
        """Return which pallets docking is not evaluated for, and why."""
        pockets, evaluated = int(self.table.has_pockets.sum()), self.overall.dockable_count
        if not pockets:
            return []
        lines = []
        unknown = int((self.table.has_pockets & (self.table.verdict == "")).sum())
        if unknown:
            lines.append(
                f"docking: of {unknown} pallets the dataset does not say whether a truck can reach them; they are "
                "evaluated all the same; generate the dataset again to have it"
            )
        if self.docking_left_out:
            reasons = ", ".join(f"{count} {reason}" for reason, count in self.docking_left_out.items())
            lines.append(f"docking: evaluated on {evaluated} of {pockets} pallets; left out: {reasons}")
        stacks = next((item for item in self.groups.get("stacking", ()) if item.label == "stacked"), None)
        if stacks is not None and stacks.dockable_count:
            fractions = [f"{100 * stacks.metrics[f'dock_{k}mm']:.1f} % with {k} mm" for k in DOCKING_MARGIN_MM]
            lines.append(f"stacks:  {', '.join(fractions)} of {stacks.dockable_count} with a free face")
        return lines


def write_scores(scores: Scores, folder: str | Path) -> Path:
    """Write scores.json, errors.csv and predictions.csv, so that the folder can be reported on its own.

    Returns:
        The path of scores.json, which is written last.
    """
    folder = Path(folder)
    make_folder(folder)
    predictions.write(folder / PREDICTIONS_FILE, scores.estimates)
    write_table(scores.table, folder / ERRORS_FILE)
    write_json(folder / SCORES_FILE, to_mapping(scores), depth=3)
    return folder / SCORES_FILE


def read_scores(folder: str | Path) -> Scores:
    """Read an evaluation folder.

    Raises:
        EvaluationError: The folder does not hold a score of this format.
    """
    folder = Path(folder)
    path = folder / SCORES_FILE
    data = read_json(path)
    if not isinstance(data, dict) or data.get("format") != SCORES_FORMAT:
        found = data.get("format") if isinstance(data, dict) else None
        raise EvaluationError(
            f"{path}: is a score of format {found}, not {SCORES_FORMAT}, and its numbers would mean something else; "
            f"run warehouse-sim evaluate again on the {PREDICTIONS_FILE} beside it"
        )
    try:
        stated = ScoresFile.read({key: value for key, value in data.items() if key != "format"}, str(path))
        estimates = tuple(predictions.read(folder / PREDICTIONS_FILE))
    except DatasetError as problem:
        raise EvaluationError(f"{problem}; run warehouse-sim evaluate again") from problem
    return Scores(**vars(stated), table=read_table(folder / ERRORS_FILE), estimates=estimates)
