"""What several trainings of each kind say together: intervals over their seeds, and which differences stand out.

Seeds differ more than test objects do: an interval over objects alone calls chance a result. Of many questions some
come out by chance, too, which Holm's correction allows for (Scand. J. Statist. 6, 1979).
"""

from collections.abc import Sequence

import numpy as np
from scipy.stats import t as student_t

from warehouse_sim.evaluation import Scores
from warehouse_sim.evaluation.intervals import scene_bootstrap, seed_interval
from warehouse_sim.evaluation.metrics import MetricConfig, pass_values

TITLES = {"add_5pct": "ADD < 5 % d", "add_10pct": "ADD < 10 % d", "dock_0mm": "docked"}
_DRAWS = 2000
_LEVEL = 0.05


def answer(question: str, first: Sequence[Scores], second: Sequence[Scores], metric: str) -> dict:
    """Return by how much the first trainings pass a metric more often than the second, one of each a seed.

    Both were scored on the same objects.
    """
    # Row by row and seed by seed: what makes a scene hard for both cancels.
    gains = np.stack([passed(a, metric) - passed(b, metric) for a, b in zip(first, second, strict=True)])
    by_seed = gains.mean(axis=1)
    scenes = first[0].table.scene_id[applies(first[0], metric)]
    return {
        "question": question,
        "metric": metric,
        "difference": round(float(by_seed.mean()), 5),
        "difference_interval": rounded(seed_interval(by_seed)),
        "scenes_interval": rounded(scene_bootstrap(gains.mean(axis=0), scenes, _DRAWS, np.random.default_rng(0))),
        "seeds": rounded(by_seed),
    }


def seed_p(values: Sequence[float]) -> float:
    """Return the two-sided p-value of Student's test that the mean over trainings is zero; 1 for one training."""
    mean, count = float(np.mean(values)), len(values)
    error = float(np.std(values, ddof=1)) / np.sqrt(count) if count > 1 else 0.0
    if error == 0.0:
        return 0.0 if count > 1 and mean else 1.0
    return float(2.0 * student_t.sf(abs(mean) / error, count - 1))


def standing(answers: Sequence[dict]) -> list[bool]:
    """Tell which differences of one metric stand out from chance, whatever number of questions was evaluated.

    Holm's correction over the questions at 5 %, and the interval over test scenes on one side of zero.
    """
    values = np.array([seed_p(row["seeds"]) for row in answers])
    order = np.argsort(values, kind="stable")
    accepted = np.zeros(len(values), dtype=bool)
    for rank, place in enumerate(order):
        if values[place] > _LEVEL / (len(values) - rank):
            break
        accepted[place] = True
    return [bool(accepted[k]) and _one_side(row["scenes_interval"]) for k, row in enumerate(answers)]


def as_markdown(answers: Sequence[dict]) -> str:
    """Return the answers as a Markdown table, in points; bold where both intervals lie on one side of zero."""
    metrics = metrics_of(answers)
    columns = [f"{TITLES[metric]}: over seeds | over scenes" for metric in metrics]
    lines = ["| question | " + " | ".join(columns) + " |", "|---|" + "---|---|" * len(metrics)]
    for question in dict.fromkeys(row["question"] for row in answers):
        cells = []
        for metric in metrics:
            row = next(row for row in answers if (row["question"], row["metric"]) == (question, metric))
            intervals = (row["difference_interval"], row["scenes_interval"])
            sure = all(low > 0 for low, _ in intervals) or all(high < 0 for _, high in intervals)
            mean, seeds, scenes = f"{100 * row['difference']:+.1f}", *map(_points, intervals)
            cells += [f"{f'**{mean}**' if sure else mean} {seeds}", scenes]
        lines.append(f"| {question} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def sentences(answers: Sequence[dict]) -> str:
    """Return in words what the intervals carry, metric by metric, and that the rest is not told from chance."""
    found = []
    for metric in metrics_of(answers):
        rows = [row for row in answers if row["metric"] == metric]
        stands = standing(rows)
        seeds = len(rows[0]["seeds"])
        carried = [f"  - {_sentence(row)}" for row, stand in zip(rows, stands, strict=True) if stand]
        if not carried:
            found.append(f"- {TITLES[metric]}: {seeds} seeds carry no answer to any of the {len(rows)} questions.")
            continue
        found.append(f"- {TITLES[metric]}, {len(carried)} of {len(rows)} questions answered by {seeds} seeds:")
        found += carried
    return "\n".join(found)


def metrics_of(answers: Sequence[dict]) -> list[str]:
    """Return the metrics that are answered, in the order of the tables."""
    return [metric for metric in TITLES if any(row["metric"] == metric for row in answers)]


def passed(scores: Scores, metric: str) -> np.ndarray:
    """Return one value in 0-1 for each object that a metric applies to."""
    return pass_values(scores.table, MetricConfig())[metric][applies(scores, metric)]


def applies(scores: Scores, metric: str) -> np.ndarray:
    """Tell for each object whether a metric applies to it."""
    return ~np.isnan(pass_values(scores.table, MetricConfig())[metric])


def rounded(values: Sequence[float]) -> list[float]:
    """Return values with five digits after the point."""
    return [round(float(value), 5) for value in values]


def _sentence(row: dict) -> str:
    verdict = "yes" if row["difference"] > 0 else "no, it costs"
    return (
        f"{row['question']}: {verdict}, {100 * row['difference']:+.1f} points {_points(row['difference_interval'])} "
        f"over seeds, {_points(row['scenes_interval'])} over scenes"
    )


def _one_side(interval: Sequence[float]) -> bool:
    low, high = interval
    return low > 0 or high < 0


def _points(interval: Sequence[float]) -> str:
    low, high = interval
    return f"[{100 * low:+.1f}, {100 * high:+.1f}]"
