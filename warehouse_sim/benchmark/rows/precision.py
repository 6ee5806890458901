"""Average precision of poses in millimetres, BOP 2025's measure for industry, with its interval over scenes."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.benchmark.rows.row import Place, Row
from warehouse_sim.benchmark.scored import Answer
from warehouse_sim.dataset.results.precision_recall import RECALLS, Matches, average_precision
from warehouse_sim.evaluation.bop_scores import matches_in_mm
from warehouse_sim.evaluation.errors.surface import ErrorModels
from warehouse_sim.evaluation.intervals import seed_interval, wilson
from warehouse_sim.evaluation.measuring import MIN_MODEL_POINTS, MIN_VISIBLE

AP_MM = "ap_mssd_mm"
"""A metric of suites that is no mean over ground truths: it ranks all estimates, wrong ones among them."""
_RESAMPLES = 200


def precision_row(answer: Answer) -> Row:
    """Return the mean average precision by MSSD from 2 to 20 mm over the objects of a dataset.

    The interval is the wider of a bootstrap over scenes and Wilson's; with several trainings it is widened to Student's
    interval over them.
    """
    opened, scene_id = answer.opened, answer.scores[0].table.scene_id
    models, images = ErrorModels(opened.reader.objects, MIN_MODEL_POINTS), opened.reader.images(opened.split)
    values, ends = [], []
    for scores in answer.scores:
        by_key = list(matches_in_mm(scores.estimates, images, models, MIN_VISIBLE).values())
        values.append(float(np.mean([average_precision([item for _, item in parts]) for parts in by_key])))
        ends.append(_over_scenes(by_key))
    value = float(np.mean(values))
    low, high = np.mean(ends, axis=0).tolist()
    one, other = wilson(value, len(scene_id))
    low, high = min(low, one), max(high, other)
    if len(values) > 1:
        one, other = seed_interval(values)
        low, high = max(min(low, one), 0.0), min(max(high, other), 1.0)
    ends_of_row = round(min(low, value), 5), round(max(high, value), 5)
    place: Place = "scores", answer.group.name, answer.condition, "all", AP_MM
    scenes = len(set(scene_id.tolist()))
    return Row(*place, round(value, 5), ends_of_row, len(scene_id), scenes, answer.group.trainings)


def _over_scenes(by_key: Sequence[Sequence[tuple[int, Matches]]]) -> tuple[float, float]:
    """Return the middle 95 % of the mean precision over resampled scenes."""
    names = sorted({scene for parts in by_key for scene, _ in parts})
    picks = np.random.default_rng(0).multinomial(len(names), np.full(len(names), 1.0 / len(names)), size=_RESAMPLES)
    sampled = np.nanmean([resampled(parts, names, picks) for parts in by_key], axis=0)
    low, high = np.nanpercentile(sampled, [2.5, 97.5])
    return float(low), float(high)


def resampled(
    parts: Sequence[tuple[int, Matches]], names: Sequence[int], picks: Int[np.ndarray, "r s"]
) -> Float[np.ndarray, " r"]:
    """Return the average precision of one object at one threshold, each scene counted as often as it is picked.

    It is nan where no scene that is picked has the object.
    """
    number = {name: position for position, name in enumerate(names)}
    wanted = np.bincount([number[s] for s, _ in parts], [item.wanted for _, item in parts], minlength=len(names))
    kept = [(item.scores[~item.ignored], item.right[~item.ignored], number[s]) for s, item in parts]
    scores = np.concatenate([item[0] for item in kept])
    order = np.argsort(-scores, kind="stable")
    right = np.concatenate([item[1] for item in kept])[order]
    weight = picks[:, np.concatenate([np.full(len(item[0]), item[2]) for item in kept]).astype(int)[order]]
    hits, total, to_find = np.cumsum(weight * right, axis=1), np.cumsum(weight, axis=1), picks @ wanted
    precision = hits / np.maximum(total, 1)
    best = np.maximum.accumulate(precision[:, ::-1], axis=1)[:, ::-1]
    found = np.full(len(picks), np.nan)
    for row in np.flatnonzero(to_find > 0):
        places = np.searchsorted(hits[row] / to_find[row], RECALLS, side="left")
        found[row] = np.append(best[row], 0.0)[np.minimum(places, len(scores))].mean()
    return found
