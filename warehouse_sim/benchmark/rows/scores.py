"""Rows of a result made of scores: fractions of every group and metric, accuracy over threshold, spread of errors."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.benchmark.groups import all_groups
from warehouse_sim.benchmark.rows.precision import AP_MM, precision_row
from warehouse_sim.benchmark.rows.row import HEADLINE, SECONDS, WORST, Place, Row, Table
from warehouse_sim.benchmark.scored import Answer
from warehouse_sim.benchmark.suite import Suite
from warehouse_sim.errors import ConfigError
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.intervals import fraction_interval, seed_interval
from warehouse_sim.evaluation.summary import DOCKING_MARGIN_MM, pass_values

RESAMPLES = 1000
_AMONG_FOUND = "_of_found"
LINEMOD_SYMMETRIC = (10, 11)
"""Eggbox and glue, of which LINEMOD's users take the distance to the nearest point (Hinterstoisser et al. 2012)."""


def metric_columns(table: ErrorTable) -> dict[str, Float[np.ndarray, " n"]]:
    """Return one value in 0-1 a ground truth by metric, nan where it does not apply.

    Beside those of ``evaluation.summary``: ``found`` has an estimate, ``add_adds_<k>pct`` takes ADD-S for LINEMOD's
    eggbox and glue and ADD for all else, ``<metric>_of_found`` leaves out what has no estimate,
    ``dock_stack_<m>mm`` is docking of pallets in a stack, taken as a whole, and ``no_unwarned_failure`` is 0 where an
    estimate does not dock though its bound lies within what the pallet leaves around the tines.
    """
    values = pass_values(table, range(1, 11))
    in_stack, of_stacks = table.stacked == 1, pass_values(table.as_stacks())
    for margin in DOCKING_MARGIN_MM:
        values[f"dock_stack_{margin}mm"] = column = np.full(len(table), np.nan)
        column[in_stack] = of_stacks[f"dock_{margin}mm"]
    symmetric = np.isin(table.obj_id, LINEMOD_SYMMETRIC)
    values |= {
        f"add_adds_{k}pct": np.where(symmetric, values[f"add_s_{k}pct"], values[f"add_{k}pct"]) for k in (2, 5, 10)
    }
    values["found"] = table.found.astype(float)
    values["no_unwarned_failure"] = _no_unwarned_failure(table)
    return values | {f"{name}{_AMONG_FOUND}": np.where(table.found, column, np.nan) for name, column in values.items()}


def _no_unwarned_failure(table: ErrorTable) -> Float[np.ndarray, " n"]:
    """Return 0 for each failure that no bound warned of, else 1; nan for who states no bounds, and without docking."""
    if np.isnan(table.error_bound).all():
        return np.full(len(table), np.nan)
    unwarned = table.found & ~table.docks() & (table.error_bound <= table.clearance)
    return np.where(table.evaluated(), 1.0 - unwarned, np.nan)


def require_metrics(suite: Suite, table: ErrorTable) -> None:
    """Check that all metrics of a suite are known.

    Raises:
        ConfigError: One is not.
    """
    known = [*metric_columns(table), AP_MM]
    if strange := [name for name in suite.metrics if name not in known]:
        raise ConfigError(f"{suite.name}: metrics: {strange[0]!r} is none; known: {', '.join(sorted(known))}")


def over_trainings(answer: Answer, metric: str) -> Float[np.ndarray, "t n"]:
    """Return the values of a metric by training and ground truth."""
    return np.stack([metric_columns(scores.table)[metric] for scores in answer.scores])


def score_rows(answer: Answer, suite: Suite) -> Iterator[Row]:
    """Yield the fractions of every group and metric of a suite, and times; then, on request, curves and spreads."""
    yield from _fraction_rows(answer, suite, "scores", [metric for metric in suite.metrics if metric != AP_MM])
    if AP_MM in suite.metrics:
        yield precision_row(answer)
    if (timed := time_row(answer)) is not None:
        yield timed
    if suite.curves:
        yield from _fraction_rows(answer, suite, "curves", [f"add_{percent}pct" for percent in range(1, 11)])
        yield from spread_rows(answer, suite)


def _fraction_rows(answer: Answer, suite: Suite, table: Table, metrics: Sequence[str]) -> Iterator[Row]:
    columns = {metric: over_trainings(answer, metric) for metric in metrics}
    subjects = answer.subjects(suite.edges)
    for label, rows in all_groups(subjects, suite.by):
        for metric, values in columns.items():
            row = _fraction_row(answer, table, label, metric, values[:, rows], subjects.table.scene_id[rows])
            if row is not None:
                yield row


def worst_rows(rows: Sequence[Row], conditions: Sequence[str]) -> Iterator[Row]:
    """Yield scores and time of each estimator under the condition where its headline is lowest, as those of ``WORST``.

    Who was not scored under every condition has none. Intervals are those of that condition.

    Args:
        rows: Of tables "scores" and "time".
        conditions: All of the suite.
    """
    whole = [row for row in rows if row.table in ("scores", "time") and row.group == "all"]
    for name in dict.fromkeys(row.estimator for row in whole):
        docked = {row.condition: row.value for row in whole if row.estimator == name and row.metric == HEADLINE}
        if set(docked) == set(conditions):
            worst = min(docked, key=lambda condition: docked[condition])
            mine = (row for row in whole if row.estimator == name and row.condition == worst)
            yield from (replace(row, condition=WORST) for row in mine)


def _fraction_row(
    answer: Answer, table: Table, label: str, metric: str, values: Float[np.ndarray, "t n"], scene_id: np.ndarray
) -> Row | None:
    """Return a fraction as a row; None where it applies to nothing.

    The interval over scenes is that of the mean over trainings; with several trainings it is widened to Student's
    interval over them, which is what another training may give.
    """
    applies = ~np.isnan(values).all(axis=0)
    if not applies.any():
        return None
    by_gt, scenes = np.nanmean(values[:, applies], axis=0), scene_id[applies]
    low, high = fraction_interval(by_gt, scenes, RESAMPLES, np.random.default_rng(0))
    value = float(by_gt.mean())
    if len(values) > 1:
        one, other = seed_interval([float(np.nanmean(part[applies])) for part in values])
        low, high = max(min(low, one), 0.0), min(max(high, other), 1.0)
    return make_row(answer, table, label, metric, value, (low, high), scenes)


def make_row(
    answer: Answer,
    table: Table,
    label: str,
    metric: str,
    value: float,
    interval: tuple[float, float],
    scene_id: np.ndarray,
    against: str = "",
) -> Row:
    """Return a row of what an entrant answered."""
    place = table, answer.group.name, answer.condition, label, metric
    return rounded_row(place, value, interval, scene_id, answer.group.trainings, against)


def mean_row(place: Place, values: Float[np.ndarray, " n"], scene_id: np.ndarray, trainings: int) -> Row:
    """Return the mean of numbers in 0-1 as a row, with its 95 % interval over scenes."""
    interval = fraction_interval(values, scene_id, RESAMPLES, np.random.default_rng(0))
    return rounded_row(place, float(values.mean()), interval, scene_id, trainings)


def rounded_row(
    place: Place,
    value: float,
    interval: tuple[float, float],
    scene_id: np.ndarray,
    trainings: int,
    against: str = "",
) -> Row:
    """Return a row whose interval holds its value, both with five digits."""
    ends = round(float(min(interval[0], value)), 5), round(float(max(interval[1], value)), 5)
    return Row(*place, round(value, 5), ends, len(scene_id), len(set(scene_id.tolist())), trainings, against)


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


_TIME_RESAMPLES = 200


def time_row(answer: Answer) -> Row | None:
    """Return the mean time that a method took for an image, detection included; None where it states none.

    Images without an estimate state nothing. The interval is over scenes; of several trainings the first is timed.
    """
    estimates = answer.scores[0].estimates
    times = {(item.scene_id, item.image_id): item.time for item in estimates if item.time >= 0.0}
    if not times:
        return None
    names, scene = np.unique([scene_id for scene_id, _ in times], return_inverse=True)
    sums, counts = np.bincount(scene, weights=list(times.values())), np.bincount(scene)
    picks = np.random.default_rng(0).multinomial(
        len(names), np.full(len(names), 1.0 / len(names)), size=_TIME_RESAMPLES
    )
    value = float(sums.sum() / counts.sum())
    low, high = np.percentile((picks @ sums) / (picks @ counts), [2.5, 97.5])
    ends = round(min(float(low), value), 5), round(max(float(high), value), 5)
    place: Place = "time", answer.group.name, answer.condition, "all", SECONDS
    trainings, machine = answer.group.trainings, answer.machine
    return Row(*place, round(value, 5), ends, len(times), len(names), trainings, machine=machine)
