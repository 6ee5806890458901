"""Results with every table, of numbers drawn at random."""

from collections.abc import Sequence

import numpy as np

from warehouse_sim.benchmark.result import DataFacts, EstimatorFacts, SuiteResult
from warehouse_sim.benchmark.rows.row import Row, Table

NAMES = ("oracle", "shuffled", "rectangle-fit", "net", "other+icp")
DISTANCES = ("0-7 m", "7-15 m", "15-25 m")


def row(
    rng: np.random.Generator,
    table: Table,
    estimator: str,
    group: str,
    metric: str,
    condition: str = "set",
    against: str = "",
) -> Row:
    """Return a row with a value and an interval around it; effects lie in -1 to 1, all else in 0 to 1."""
    low, value, high = np.sort(rng.uniform(-1.0 if table == "effects" else 0.0, 1.0, 3)).round(5).tolist()
    return Row(table, estimator, condition, group, metric, value, (low, high), 40, 4, 0, against)


def result(rows: Sequence[Row], facts: Sequence[EstimatorFacts] = (), suite: str = "made-v1") -> SuiteResult:
    """Return a result of rows, of the estimators in them where no others are given."""
    known = tuple(facts) or tuple(EstimatorFacts(name, 0) for name in dict.fromkeys(item.estimator for item in rows))
    data = (DataFacts("set", "smoke", "ab12", 1, 4, 8, 40),)
    return SuiteResult(suite, "Which?", False, "bench made", {"cores": 2}, 1.5, 0, data, known, tuple(rows))


def everything(names: Sequence[str] = NAMES, seed: int = 0) -> SuiteResult:
    """Return a result with all tables: scores by distance, class and condition, effects, curves and so on."""
    rng, rows = np.random.default_rng(seed), []
    for name in names:
        for metric in ("dock_0mm", "add_10pct"):
            rows += [row(rng, "scores", name, group, metric) for group in ("all", *DISTANCES, "carton", "pallet")]
            rows += [row(rng, "scores", name, "all", metric, "dilated")]
            rows += [
                row(rng, "effects", name, f"light: {level}", metric, against="base")
                for level in ("dim", "night", "off")
            ]
        rows += [row(rng, "curves", name, group, f"add_{k}pct") for group in ("all", "pallet") for k in range(1, 11)]
        rows += spread(rng, name)
        rows += [row(rng, "detection", name, "pallet", "ap_box_50")]
        rows += [row(rng, "precision", name, "pallet", f"at_recall_{k}") for k in range(10, 101, 10)]
        rows += [row(rng, "confusion", name, true, f"as {label}") for true in ("carton", "pallet") for label in LABELS]
        rows += [row(rng, "confusion", name, "what was found", "as nothing")]
        rows += [row(rng, "simulated", name, "truck", metric) for metric in ("docked", "swept_docked")]
        rows += [row(rng, "driven", name, "closed loop truck: base", metric) for metric in ("docked", "aborted")]
    return result(rows)


LABELS = ("carton", "pallet", "missed")


def spread(rng: np.random.Generator, name: str) -> list[Row]:
    """Return the five quantiles of a spread, rising, above a thousandth, and with intervals."""
    values = np.sort(10.0 ** rng.uniform(-2.5, 0.0, 5)).round(5).tolist()
    return [
        Row("spread", name, "set", "all", f"add_q{q}", value, (0.9 * value, min(1.1 * value, 1.0)), 40, 4)
        for q, value in zip(("05", "25", "50", "75", "95"), values, strict=True)
    ]
