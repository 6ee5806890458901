"""How an error is spread: the quantiles that a box plot is drawn of, each with an interval."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from warehouse_sim.benchmark.groups import all_groups
from warehouse_sim.benchmark.rows.row import Row
from warehouse_sim.benchmark.rows.scores import make_row
from warehouse_sim.benchmark.scored import Answer
from warehouse_sim.benchmark.suite import Suite

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
_RESAMPLES = 500
_Z = 1.959963984540054


def spread_rows(answer: Answer, suite: Suite) -> Iterator[Row]:
    """Yield quantiles of ADD as a fraction of the diameter, 1 for what is missed or farther off, for every group."""
    subjects = answer.subjects(suite.edges)
    errors = np.concatenate([np.minimum(s.table.add / s.table.diameter, 1.0) for s in answer.scores])
    scenes = np.concatenate([s.table.scene_id for s in answer.scores])
    for label, rows in all_groups(subjects, suite.by):
        chosen = np.tile(rows, len(answer.scores))
        for fraction in QUANTILES:
            value, interval = quantile(errors[chosen], scenes[chosen], fraction, np.random.default_rng(0))
            name = f"add_q{round(100 * fraction):02d}"
            yield make_row(answer, "spread", label, name, value, interval, subjects.table.scene_id[rows])


def quantile(
    values: Float[np.ndarray, " n"], scene_id: np.ndarray, fraction: float, rng: np.random.Generator
) -> tuple[float, tuple[float, float]]:
    """Return a quantile and the wider of two 95 % intervals on each side.

    One resamples scenes; the other is that of order statistics (Conover 1999, 3.2), which has a width with one scene.

    Args:
        values: n >= 1 numbers.
        scene_id: Scene of each.
        fraction: Which quantile, 0-1.
        rng: Source of the resamples.
    """
    ordered, count = np.sort(values), len(values)
    off = _Z * np.sqrt(count * fraction * (1.0 - fraction))
    low, high = (
        int(np.clip(rank, 0, count - 1)) for rank in (np.floor(count * fraction - off), np.ceil(count * fraction + off))
    )
    names = np.unique(scene_id)
    parts = [values[scene_id == name] for name in names]
    picks = rng.integers(len(names), size=(_RESAMPLES, len(names)))
    sampled = [np.quantile(np.concatenate([parts[number] for number in row]), fraction) for row in picks]
    ends = np.percentile(sampled, [2.5, 97.5])
    value = float(np.quantile(values, fraction))
    return value, (min(float(ends[0]), float(ordered[low]), value), max(float(ends[1]), float(ordered[high]), value))
