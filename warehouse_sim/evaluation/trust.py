"""What an estimator's uncertainty is worth: ranking, risk by coverage, and how often its bound holds."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.stats import rankdata

from warehouse_sim.dataset.files.record import Record, Whole
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.intervals import fraction_interval
from warehouse_sim.evaluation.stated import STATED, Number
from warehouse_sim.evaluation.summary import RESAMPLES, RESAMPLING_SEED, split_groups

_DIAMETERS = 0.05
"""An object without pockets is right within this fraction of its diameter (ADD)."""


@dataclass(frozen=True, eq=False)
class RiskCoverage:
    """What fraction fails among those that are kept, when the least sure are rejected; one point a distinct score."""

    coverage: Float[np.ndarray, " k"]
    """Fraction of the estimates that are kept, rising to 1."""
    risk: Float[np.ndarray, " k"]
    """Fraction of these that fail."""
    score: Float[np.ndarray, " k"]
    """Least score that is kept, falling."""

    @property
    def area(self) -> float:
        """The mean risk over all coverages (AURC), each estimate counting once; ties share the risk of their group."""
        return float((np.diff(self.coverage, prepend=0.0) * self.risk).sum())


def succeeded(table: ErrorTable) -> Bool[np.ndarray, " n"]:
    """Return which estimates dock, or for objects that no fork can enter, have an ADD under 5 % of the diameter."""
    return np.where(table.clearance >= 0.0, table.docks(), table.add < _DIAMETERS * table.diameter).astype(bool)


def auroc(score: Float[np.ndarray, " n"], right: Bool[np.ndarray, " n"]) -> float:
    """Return the probability that a right estimate has a higher score than a wrong one, ties counting half.

    The area under the ROC curve is the Mann-Whitney statistic over its largest value (Hanley and McNeil, Radiology 143,
    1982). It is nan where all are right or all are wrong.
    """
    positive, negative = int(right.sum()), int((~right).sum())
    if positive == 0 or negative == 0:
        return float("nan")
    ranks = rankdata(score)
    return float((ranks[right].sum() - positive * (positive + 1) / 2.0) / (positive * negative))


def auroc_interval(
    score: Float[np.ndarray, " n"],
    right: Bool[np.ndarray, " n"],
    scene_id: Int[np.ndarray, " n"],
    resamples: int,
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Return the 95 % percentile interval of ``auroc`` under resampling of whole scenes.

    Resamples without a right or without a wrong estimate say nothing and are left out; nan where all are.
    """
    names, scene = np.unique(scene_id, return_inverse=True)
    order = np.argsort(score, kind="stable")
    scene, right = scene[order], right[order]
    first = np.flatnonzero(np.append(True, np.diff(score[order]) != 0.0)) if len(order) else order
    known = []
    for _ in range(resamples):
        # Rows of a scene that is drawn twice count twice: one order of the scores serves all resamples.
        weight = np.bincount(rng.integers(len(names), size=len(names)), minlength=len(names))[scene]
        positive, all_ = np.add.reduceat(weight * right, first), np.add.reduceat(weight, first)
        negative = all_ - positive
        pairs = int(positive.sum()) * int(negative.sum())
        if pairs:
            below = np.cumsum(negative) - negative
            known.append(float((positive * (2 * below + negative)).sum() / (2 * pairs)))
    if not known:
        return float("nan"), float("nan")
    low, high = np.percentile(known, [2.5, 97.5])
    return float(low), float(high)


def risk_coverage(score: Float[np.ndarray, " n"], right: Bool[np.ndarray, " n"]) -> RiskCoverage:
    """Return the risk-coverage curve of selective prediction (Geifman and El-Yaniv, NIPS 2017), n >= 1.

    Estimates of one score are kept or rejected together: no order among them is invented.
    """
    order = np.argsort(-score, kind="stable")
    ordered, failed = score[order], np.cumsum(~right[order])
    last = np.append(ordered[1:] != ordered[:-1], True)
    kept = np.flatnonzero(last) + 1
    return RiskCoverage(kept / len(score), failed[last] / kept, ordered[last])


def least_area(right: Bool[np.ndarray, " n"]) -> float:
    """Return the AURC of a score that ranks every right estimate before every wrong one."""
    wrong, count = int((~right).sum()), len(right)
    kept = np.arange(1, count + 1)
    return float((np.maximum(kept - (count - wrong), 0) / kept).mean())


_AT = tuple(step / 20 for step in range(1, 21))
"""Coverages at which a score states the risk."""
_LEAST = 10
"""A fraction of fewer estimates says nothing."""


@dataclass(frozen=True, eq=False)
class BoundCoverage(Record):
    """How often a bound held that should hold in nine cases of ten."""

    label: str
    """Which estimates: "all", or a range of distances."""
    count: Whole
    """Estimates that state a bound."""
    fraction: Number = field(metadata=STATED)
    """Of them, those whose surface lies closer to its true place (RMS)."""
    interval: tuple[Number, Number] = field(metadata=STATED)
    """95 % interval over scenes."""
    median_bound: Number = field(metadata=STATED)
    """Median of the bounds (m): a bound that always holds is worth little if it is wide."""


@dataclass(frozen=True, eq=False)
class Trust(Record):
    """Over the estimates of ground truths that count; a right one docks, or has ADD under 5 % of the diameter."""

    estimates: Whole
    """How many there are; ground truths without one are no part of this."""
    failures: Whole
    """How many of them are wrong."""
    auroc: Number = field(metadata=STATED)
    """Probability that a right one is scored above a wrong one; nan without one of each."""
    auroc_interval: tuple[Number, Number] = field(metadata=STATED)
    """95 %, bootstrap over scenes."""
    aurc: Number = field(metadata=STATED)
    """Area under the risk-coverage curve; nan without estimates."""
    aurc_least: Number = field(metadata=STATED)
    """The same area with a perfect ranking."""
    risk_at: tuple[tuple[Number, Number], ...] = field(metadata=STATED)
    """(coverage, fraction of failures among the best scored), coverage in steps of 5 %."""
    bound: tuple[BoundCoverage, ...]
    """Of all and by distance; empty where no bound is stated."""


def trust_of(table: ErrorTable) -> Trust:
    """Measure the uncertainty behind the estimates of a table, which may be empty."""
    found = table.select(table.found)
    right, bound = succeeded(found), bound_coverage(found)
    nothing = float("nan")
    if len(found) == 0:
        return Trust(0, 0, nothing, (nothing, nothing), nothing, nothing, (), bound)
    rng = np.random.default_rng(RESAMPLING_SEED)
    curve = risk_coverage(found.score, right)
    return Trust(
        len(found),
        int((~right).sum()),
        auroc(found.score, right),
        auroc_interval(found.score, right, found.scene_id, RESAMPLES, rng),
        curve.area,
        least_area(right),
        tuple((fraction, float(curve.risk[np.searchsorted(curve.coverage, fraction - 1e-9)])) for fraction in _AT),
        bound,
    )


def bound_coverage(found: ErrorTable) -> tuple[BoundCoverage, ...]:
    """Return how often the stated bounds hold, of all estimates and by distance; ranges with few are left out."""
    nominal = found.select(~np.isnan(found.error_bound))
    ranges = [("all", np.ones(len(nominal), dtype=bool)), *split_groups(nominal)["distance"]]
    rows = []
    for label, chosen in ranges:
        part = nominal.select(chosen)
        if len(part) >= _LEAST:
            holds = (part.surface_rms <= part.error_bound).astype(float)
            rng = np.random.default_rng(RESAMPLING_SEED)
            interval = fraction_interval(holds, part.scene_id, RESAMPLES, rng)
            width = float(np.median(part.error_bound))
            rows.append(BoundCoverage(label, len(part), float(holds.mean()), interval, width))
    return tuple(rows)
