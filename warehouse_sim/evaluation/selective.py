"""Whether scores tell right estimates from wrong ones: ranking, and what is gained by rejecting the least sure."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.stats import rankdata

from warehouse_sim.evaluation.error_table import ErrorTable

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
