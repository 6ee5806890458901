"""How long methods take, and on what machine."""

import numpy as np

from warehouse_sim.benchmark.rows.row import SECONDS, Place, Row
from warehouse_sim.benchmark.scored import Answer

_RESAMPLES = 200


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
    picks = np.random.default_rng(0).multinomial(len(names), np.full(len(names), 1.0 / len(names)), size=_RESAMPLES)
    value = float(sums.sum() / counts.sum())
    low, high = np.percentile((picks @ sums) / (picks @ counts), [2.5, 97.5])
    ends = round(min(float(low), value), 5), round(max(float(high), value), 5)
    place: Place = "time", answer.group.name, answer.condition, "all", SECONDS
    trainings, machine = answer.group.trainings, answer.machine
    return Row(*place, round(value, 5), ends, len(times), len(names), trainings, machine=machine)
