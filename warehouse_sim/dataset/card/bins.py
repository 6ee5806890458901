"""Counts of labelled targets in bins of what makes a pose hard, by split, and as bars of text."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from warehouse_sim.dataset.stored.observation_record import RecordedObservation

_WIDTH = 40


def text_bars(counts: Mapping[str, int], width: int = _WIDTH) -> list[str]:
    """Return one line for each entry: its name, a bar, the count and its fraction of all.

    Args:
        counts: Name -> count, in the order of the lines.
        width: Characters of the longest bar.
    """
    most, total = max(counts.values(), default=0), sum(counts.values())
    names = max(map(len, counts), default=0)
    numbers = len(f"{most:,}")
    lines = []
    for name, count in counts.items():
        # What is there is seen, however little it is.
        length = max(round(width * count / most), 1) if count else 0
        fraction = f"{100 * count / total:5.1f} %" if count else ""
        lines.append(f"{name:<{names}} |{'#' * length:<{width}} {count:>{numbers},} {fraction}".rstrip())
    return lines


def bin_names(edges: Sequence[float], last_open: bool = True) -> list[str]:
    """Return a name for each bin between two edges; the last one takes what lies beyond unless it is not open."""
    shown = [f"{edge:g}" for edge in edges]
    left, right = max(map(len, shown[:-1])), max(map(len, shown[1:]))
    names = [f"{low:>{left}} - {high:<{right}}" for low, high in pairwise(shown)]
    return [*names[:-1], f"{shown[-2]:>{left}} -"] if last_open else names


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
