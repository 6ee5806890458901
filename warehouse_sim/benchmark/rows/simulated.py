"""The simulated truck in suites: it drives to estimated poses, or with an estimator in the loop."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from warehouse_sim.benchmark.entrants.entrant import Evaluated, Group
from warehouse_sim.benchmark.entrants.ways import Way
from warehouse_sim.benchmark.rows.row import Place, Row
from warehouse_sim.benchmark.rows.scores import mean_row
from warehouse_sim.benchmark.scored import Answer
from warehouse_sim.benchmark.suite import ApproachConfig, ConditionConfig
from warehouse_sim.dataset.results import predictions
from warehouse_sim.output import make_folder
from warehouse_sim.registry import Registry


@dataclass(frozen=True)
class Verdict:
    """What became of one pose."""

    scene_id: int
    docked: bool
    """Whether the truck took the pallet."""
    swept: bool
    """What the swept-volume check of ``evaluate`` says of the same pose."""


class DockingSimulation(Protocol):
    """Drives a truck to the poses of a file of predictions on a dataset."""

    def __call__(self, data: Path, predictions: Path, split: str, most: int) -> Sequence[Verdict]:
        """Return a verdict for each of at most ``most`` poses that docking is evaluated of."""


SIMULATIONS = Registry("docking simulation")
"""Names that stand for a ``DockingSimulation``; entry points of the group ``warehouse_sim.docking_simulations``."""
SIMULATIONS.add("truck", "warehouse_sim.benchmark.docking.record:truck_verdicts")


@dataclass(frozen=True)
class Drive:
    """How one approach with an estimator in the loop ended."""

    method: str
    source: str
    """Recipe."""
    level: str
    scene_id: int
    docked: bool
    aborted: bool
    """Whether the truck stopped by itself."""


class ClosedLoop(Protocol):
    """Drives approaches with estimators in the loop."""

    def __call__(
        self, config: ApproachConfig, ways: Mapping[str, Way], inputs: Mapping[str, Any], out: Path
    ) -> Iterator[Drive]:
        """Yield how each episode ended, of the ground truth and of all ``ways``."""


CLOSED_LOOPS = Registry("closed loop")
"""Names that stand for a ``ClosedLoop``; entry points of the group ``warehouse_sim.closed_loops``."""
CLOSED_LOOPS.add("truck", "warehouse_sim.benchmark.docking.closed_loop.run:drives")


def simulated_rows(answer: Answer, out: Path, most: int) -> Iterator[Row]:
    """Yield each registered simulation's answer on ``most`` poses: docked, and agreement with the check."""
    for name in SIMULATIONS.names():
        simulate: DockingSimulation = SIMULATIONS.get(name)
        folder = out / "simulated" / f"{answer.group.name}-{answer.condition}".replace("/", "-")
        make_folder(folder)
        verdicts: list[Verdict] = []
        for number, scores in enumerate(answer.scores):
            path = folder / f"predictions_{number}.csv"
            predictions.write(path, scores.estimates)
            verdicts += simulate(answer.opened.made.root, path, answer.opened.split, most)
        if not verdicts:
            continue
        scenes = np.array([item.scene_id for item in verdicts])
        values = {
            "docked": [item.docked for item in verdicts],
            "swept_docked": [item.swept for item in verdicts],
            "swept_agrees": [item.docked == item.swept for item in verdicts],
        }
        for metric, column in values.items():
            place: Place = "simulated", answer.group.name, answer.condition, name, metric
            yield mean_row(place, np.array(column, dtype=float), scenes, answer.group.trainings)


def driven_rows(groups: Sequence[Group], config: ApproachConfig, out: Path) -> Iterator[Row]:
    """Yield for each who drives, recipe and level the fractions that dock and that stop by themselves.

    Of several trainings the first drives.
    """
    evaluated = {
        group.name: group.members[0]
        for group in groups
        if isinstance(group.members[0], Evaluated) and group.name in (config.estimators or (group.name,))
    }
    ways = {name: item.way for name, item in evaluated.items() if isinstance(item, Evaluated)}
    inputs = {name: item.inputs(ConditionConfig("")) for name, item in evaluated.items()}
    trainings = {name: item.trainings for name, item in evaluated.items()}
    names = {group.name for group in groups}
    folder = out / "closed_loop"
    for loop in CLOSED_LOOPS.names() if config.recipes else ():
        make_folder(folder)
        drive: ClosedLoop = CLOSED_LOOPS.get(loop)
        found: dict[tuple[str, str, str], list[Drive]] = {}
        for item in drive(config, ways, inputs, folder):
            found.setdefault((item.method, item.source, item.level), []).append(item)
        for (method, source, level), items in found.items():
            if method not in names:
                continue  # the ground truth drives anyway
            scenes = np.array([item.scene_id for item in items])
            for metric in ("docked", "aborted"):
                fraction = np.array([getattr(item, metric) for item in items], dtype=float)
                place: Place = "driven", method, source, f"closed loop {loop}: {level}", metric
                yield mean_row(place, fraction, scenes, trainings.get(method, 0))
