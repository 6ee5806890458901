"""How the splits compare in what makes a pose hard to estimate: counts of labelled targets in bins."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from warehouse_sim.dataset.observation_record import RecordedObservation

BINS: dict[str, tuple[float, ...]] = {
    "visible_fraction": (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0),
    "distance": (0.0, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 25.0, 50.0),
    "lux": (0.0, 10.0, 30.0, 100.0, 200.0, 300.0, 500.0, 1000.0, 5000.0),
}
"""Edges of the bins; the last bin takes what lies beyond. Distance in m; lux on the target's visible surface."""


def split_table(splits: dict[str, Iterable[Sequence[RecordedObservation]]]) -> dict[str, Any]:
    """Return, for each split, how many scenes, observations and labelled targets it has, and targets by bin.

    Args:
        splits: The observations of every scene of each split.
    """
    return {"bins": {name: list(edges) for name, edges in BINS.items()}} | {
        name: _row(list(scenes)) for name, scenes in splits.items()
    }


def _row(scenes: list[Sequence[RecordedObservation]]) -> dict[str, Any]:
    observations = [item for scene in scenes for item in scene]
    targets = [target for item in observations for target in item.targets]
    values = {
        "visible_fraction": [item.visible_fraction for item in targets],
        "distance": [item.distance for item in targets],
        "lux": [item.illuminance for item in targets if item.illuminance is not None],
    }
    counts = {name: count_in_bins(found, name) for name, found in values.items()}
    return {"scenes": len(scenes), "observations": len(observations), "targets": len(targets), **counts}


def count_in_bins(values: Sequence[float], name: str) -> list[int]:
    """Return how many values lie in each of the ``BINS`` of that name; what lies beyond counts in the outer ones."""
    edges = BINS[name]
    counts: list[int] = np.histogram(np.clip(values, edges[0], edges[-1]), edges)[0].tolist()
    return counts
