"""Where a simulated truck comes in: whoever simulates docking registers it, and suites ask it about their poses."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from warehouse_sim.benchmark.rows import DRAWS, Row, make_row
from warehouse_sim.benchmark.scored import Answer
from warehouse_sim.dataset.results import predictions
from warehouse_sim.evaluation.intervals import share_interval
from warehouse_sim.output import make_folder
from warehouse_sim.registry import Registry


@dataclass(frozen=True)
class Verdict:
    """What became of one pose."""

    scene_id: int
    docked: bool
    """Whether the truck took the pallet."""
    swept: bool
    """What the swept test of ``evaluate`` says of the same pose."""


class DockingSimulation(Protocol):
    """Drives a truck to the poses of a file of predictions on a dataset."""

    def __call__(self, data: Path, predictions: Path, split: str) -> Sequence[Verdict]:
        """Return a verdict for each pose that docking is asked of."""


SIMULATIONS = Registry("docking simulation")
"""Names that stand for a ``DockingSimulation``; entry points of the group ``warehouse_sim.docking_simulations``."""


def simulated_rows(answer: Answer, out: Path) -> Iterator[Row]:
    """Yield what each registered simulation says of an answer: docked, and agreement with the swept test."""
    for name in SIMULATIONS.names():
        simulate: DockingSimulation = SIMULATIONS.get(name)
        folder = out / "simulated" / f"{answer.group.name}-{answer.condition}".replace("/", "-")
        make_folder(folder)
        verdicts: list[Verdict] = []
        for number, scores in enumerate(answer.scores):
            path = folder / f"predictions_{number}.csv"
            predictions.write(path, scores.estimates)
            verdicts += simulate(answer.opened.made.root, path, answer.opened.split)
        if not verdicts:
            continue
        scenes = np.array([item.scene_id for item in verdicts])
        values = {
            "docked": [item.docked for item in verdicts],
            "swept_docked": [item.swept for item in verdicts],
            "swept_agrees": [item.docked == item.swept for item in verdicts],
        }
        for metric, column in values.items():
            share = np.array(column, dtype=float)
            low, high = share_interval(share, scenes, DRAWS, np.random.default_rng(0))
            value = float(share.mean())
            yield make_row(answer, "simulated", name, metric, value, (min(low, value), max(high, value)), scenes)
