"""Fit uncertainty: boosted stumps of scikit-learn, stored as sums of steps, and judged on held-out scenes."""

from collections.abc import Callable, Sequence

import numpy as np

from trainings.uncertainty_samples import Samples
from warehouse_sim.estimators.pose.choose import Selection
from warehouse_sim.estimators.pose.uncertainty.covariance import rms_quantile
from warehouse_sim.estimators.pose.uncertainty.estimator import NINE_OF_TEN
from warehouse_sim.estimators.pose.uncertainty.model import Steps, StepSum, UncertaintyModel
from warehouse_sim.estimators.settings import Refinement
from warehouse_sim.evaluation.trust import auroc

RANGE_EDGES = (2.0, 4.0, 6.0, 8.0, 10.0)
"""Distances (m) between which the bound has a factor of its own."""
_FOLDS = 5
_COVERED = 0.9
_BOOST = {"max_depth": 1, "learning_rate": 0.05, "subsample": 0.5, "min_samples_leaf": 25, "random_state": 0}
_ROUNDS = 300
_LEAST_ERROR = 1e-4

Boosted = Callable[[np.ndarray, np.ndarray, np.ndarray], StepSum]


def fit(samples: Samples, selection: Selection, refine: Refinement) -> UncertaintyModel:
    """Return the model of one way of prediction.

    Args:
        samples: Estimates under errors of masks and sensors; each dataset and disturbance weighs the same.
        selection: How poses were chosen.
        refine: What followed.
    """
    x, weight = samples.features, _weights(samples.group)
    ratio = np.log(np.maximum(samples.error, _LEAST_ERROR) / of_readings(samples))
    fits: tuple[tuple[Boosted, np.ndarray], ...] = (
        (_classify, samples.right.astype(int)),
        (_quantile(_COVERED), ratio),
        (_quantile(0.5), ratio),
    )
    right, high, _ = (_left_out(boosted, samples.names, x, y, weight, samples.scene) for boosted, y in fits)
    factors = _range_factors(ratio - high, samples, weight)
    holds = ratio - high <= np.log(factors[_bin(samples)])
    score, scale, median = (_named(boosted(x, y, weight), samples.names) for boosted, y in fits)
    return UncertaintyModel(
        selection,
        refine,
        score,
        scale,
        median,
        RANGE_EDGES,
        tuple(round(float(value), 4) for value in factors),
        len(ratio),
        round(auroc(right, samples.right), 4),
        round(float(np.average(holds, weights=weight)), 4),
    )


def of_readings(samples: Samples) -> np.ndarray:
    """Return the 90 % quantile of the RMS distance of the surface by the readings alone (m)."""
    pairs = zip(samples.covariance, samples.metric, strict=True)
    return np.array([rms_quantile(covariance, metric, NINE_OF_TEN) for covariance, metric in pairs])


def evaluate_steps(steps: StepSum, names: Sequence[str], x: np.ndarray) -> np.ndarray:
    """Return the sum at each row of ``x``."""
    total = np.full(len(x), steps.constant)
    for item in steps.steps:
        total += np.array(item.value)[np.searchsorted(item.at, x[:, names.index(item.feature)], side="left")]
    return total


def _left_out(
    boosted: Boosted, names: Sequence[str], x: np.ndarray, y: np.ndarray, weight: np.ndarray, scene: np.ndarray
) -> np.ndarray:
    """Return what is predicted of each row by a fit on other scenes."""
    fold = np.unique(scene, return_inverse=True)[1] % _FOLDS
    found = np.empty(len(y))
    for k in np.unique(fold):
        steps = _named(boosted(x[fold != k], y[fold != k], weight[fold != k]), names)
        found[fold == k] = evaluate_steps(steps, list(names), x[fold == k])
    return found


def _range_factors(rest: np.ndarray, samples: Samples, weight: np.ndarray) -> np.ndarray:
    """Return for each range the factor below which nine of ten of the errors that were left out stay.

    Split conformal prediction within groups (Vovk, "Conditional validity of inductive conformal predictors", 2013).
    """
    place = _bin(samples)
    return np.array([
        np.exp(_weighted_quantile(rest[place == k], weight[place == k])) if (place == k).sum() >= 30 else
        np.exp(_weighted_quantile(rest, weight))
        for k in range(len(RANGE_EDGES) + 1)
    ])  # fmt: skip


def _bin(samples: Samples) -> np.ndarray:
    distance = np.exp(samples.features[:, samples.names.index("log_range")])
    return np.searchsorted(RANGE_EDGES, distance, side="left")


def _weighted_quantile(values: np.ndarray, weight: np.ndarray) -> float:
    order = np.argsort(values)
    reached = np.cumsum(weight[order])
    place = np.searchsorted(reached, min(_COVERED * (1.0 + 1.0 / max(len(values), 1)), 1.0) * reached[-1])
    return float(values[order[min(place, len(values) - 1)]])


def _weights(group: np.ndarray) -> np.ndarray:
    _, number, count = np.unique(group, return_inverse=True, return_counts=True)
    return (len(group) / len(count) / count)[number]


def _classify(x: np.ndarray, y: np.ndarray, weight: np.ndarray) -> StepSum:
    from sklearn.ensemble import GradientBoostingClassifier

    fitted = GradientBoostingClassifier(n_estimators=_ROUNDS, **_BOOST).fit(x, y, sample_weight=weight)
    return _as_steps(fitted, fitted.decision_function(x[:1])[0], x[0])


def _quantile(fraction: float) -> Boosted:
    def boosted(x: np.ndarray, y: np.ndarray, weight: np.ndarray) -> StepSum:
        from sklearn.ensemble import GradientBoostingRegressor

        fitted = GradientBoostingRegressor(loss="quantile", alpha=fraction, n_estimators=_ROUNDS, **_BOOST)
        fitted.fit(x, y, sample_weight=weight)
        return _as_steps(fitted, fitted.predict(x[:1])[0], x[0])

    return boosted


def _as_steps(fitted, value: float, row: np.ndarray) -> StepSum:  # type: ignore[no-untyped-def]
    """Put stumps together by feature; the constant is what makes the sum ``value`` at ``row``."""
    jumps: dict[int, dict[float, float]] = {}
    for (tree,) in fitted.estimators_:
        nodes = tree.tree_
        leaves = fitted.learning_rate * nodes.value[:, 0, 0]
        if nodes.node_count == 1:
            continue
        found, edge = jumps.setdefault(int(nodes.feature[0]), {}), round(float(nodes.threshold[0]), 5)
        found[edge] = found.get(edge, 0.0) + float(leaves[2] - leaves[1])
    steps = []
    for feature, found in sorted(jumps.items()):
        at = sorted(found)
        values = np.concatenate([[0.0], np.cumsum([found[key] for key in at])])
        steps.append(Steps(str(feature), tuple(at), tuple(round(float(item), 5) for item in values)))
    bare = StepSum(0.0, tuple(steps))
    rest = value - bare.value({str(i): float(item) for i, item in enumerate(row)})
    return StepSum(round(float(rest), 5), bare.steps)


def _named(steps: StepSum, names: Sequence[str]) -> StepSum:
    named = tuple(Steps(names[int(item.feature)], item.at, item.value) for item in steps.steps)
    return StepSum(steps.constant, named)
