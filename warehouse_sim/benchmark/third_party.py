"""Third-party folders in place of a suite's own data, in the protocol of the dissertation that the suites follow."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool

from warehouse_sim.benchmark.entrants.entrant import LADDER
from warehouse_sim.benchmark.groups import lidar_points, places_of
from warehouse_sim.benchmark.rows.precision import AP_MM
from warehouse_sim.benchmark.scored import SPLITS, Answer, Opened, posed_split
from warehouse_sim.benchmark.sets import MadeSet
from warehouse_sim.benchmark.suite import ConditionConfig, NegativesConfig, Suite
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import EvaluationError, InputError

LINEMOD_OBJECTS = (1, 2, 4, 5, 6, 8, 9, 10, 11, 12, 13, 14, 15)
"""The thirteen of LINEMOD that have a mesh in every copy of it: all but bowl (3) and cup (7)."""
KITTI_CLASSES = ("Car", "Pedestrian")
_NEAR, _ENOUGH_POINTS = 7.0, 100


@dataclass(frozen=True)
class Protocol:
    """Which third-party ground truths count, and their description."""

    kind: str
    """``linemod`` or ``kitti``."""
    objects: tuple[int, ...] = ()
    """Numbers of those that count; all if empty."""
    classes: tuple[str, ...] = ()
    """Those that count; all if empty."""
    nearer_than: float = np.inf
    """Distance (m) below which they count."""
    least_points: int = 0
    """LiDAR points that they must have."""

    @property
    def text(self) -> str:
        """What counts, in words."""
        parts = [f"objects {', '.join(map(str, self.objects))}" if self.objects else ""]
        parts.append(" and ".join(self.classes))
        parts.append(f"nearer than {self.nearer_than:g} m" if np.isfinite(self.nearer_than) else "")
        parts.append(f"at least {self.least_points} LiDAR points" if self.least_points else "")
        return f"counted: {'; '.join(filter(None, parts)) or 'all'}"

    def counts(self, answer: Answer) -> Bool[np.ndarray, " n"]:
        """Return which ground truths of an answer count."""
        table = answer.scores[0].table
        rows = table.distance < self.nearer_than
        rows &= np.isin(table.obj_id, self.objects) if self.objects else True
        rows &= np.isin(table.class_name, self.classes) if self.classes else True
        if self.least_points:
            points = [answer.opened.points.get(place, 0) for place in places_of(table)]
            rows &= np.array(points, dtype=int) >= self.least_points
        return rows


def kind_of(reader: DatasetReader) -> str:
    """Return whether a third-party folder is LINEMOD's or KITTI's by what stands for its objects; else ``other``."""
    infos = list(reader.objects.values())
    if infos and not any(info.has_cad for info in infos):
        return "kitti"
    return "linemod" if reader.manifest is None and any(info.is_scan for info in infos) else "other"


def protocol(suite: Suite, reader: DatasetReader, data: Path) -> Protocol:
    """Return the protocol of a suite for a folder.

    Raises:
        InputError: The suite does not take such a folder.
    """
    kind = kind_of(reader)
    if kind not in suite.takes:
        takes = f"takes third-party data of {' and '.join(suite.takes)}" if suite.takes else "takes no third-party data"
        found = "" if kind == "other" else f", found {kind}"
        raise InputError(
            f"--data {data}: the suite {suite.name} {takes}{found}; leave --data out or choose another suite"
        )
    if kind == "linemod":
        return Protocol(kind, objects=LINEMOD_OBJECTS)
    if suite.name == "distance":  # its groups are by distance and points
        return Protocol(kind, classes=KITTI_CLASSES)
    return Protocol(kind, classes=KITTI_CLASSES, nearer_than=_NEAR, least_points=_ENOUGH_POINTS)


def on_folder(suite: Suite, data: Path) -> tuple[Suite, Opened, Protocol]:
    """Return the suite for a folder, the folder, and which of its ground truths count.

    Conditions that differ in nothing but the data become one; docking is not evaluated on KITTI, which has no CAD.

    Raises:
        InputError: The suite does not take such a folder.
        DatasetError: It cannot be read.
    """
    reader = DatasetReader(data)
    rules = protocol(suite, reader, data)
    name = data.resolve().name
    split = posed_split(reader)
    if not split:
        raise InputError(f"{data}: none of the splits {', '.join(SPLITS)} has poses to score against")
    points = lidar_points(reader, split) if rules.kind == "kitti" else {}
    opened = Opened(MadeSet(name, data), reader, points, split)
    conditions: dict[str, ConditionConfig] = {}
    seen = []
    for label, item in suite.evaluated.items():
        evaluated = replace(item, data=name, estimators=())
        if replace(evaluated, data="") not in seen:
            seen.append(replace(evaluated, data=""))
            conditions[label if suite.conditions else name] = evaluated
    # Precision ranks all estimates; a protocol counts some objects alone.
    metrics = [metric for metric in suite.metrics if not metric.startswith("dock") and metric != AP_MM]
    if rules.kind == "linemod":
        metrics = [*dict.fromkeys(["add_adds_10pct", "add_adds_5pct", *metrics])]
    by = tuple(dict.fromkeys([*suite.by, "object" if rules.kind == "linemod" else "class"]))
    trainings = {key: replace(item, data=(name,)) for key, item in suite.trainings.items()}
    changed = replace(
        suite,
        data={},
        conditions=conditions,
        estimators=LADDER,  # bundled networks do not know third-party objects
        metrics=tuple(metrics),
        by=by,
        detectors=(),
        trainings=trainings,
        simulate=False,
        negatives=NegativesConfig(),
    )
    return changed, opened, rules


def counted(answers: Sequence[Answer], rules: Protocol, data: Path) -> list[Answer]:
    """Return answers to what counts by a protocol.

    Raises:
        EvaluationError: Nothing does.
    """
    found = []
    for answer in answers:
        rows = rules.counts(answer)
        if not rows.any():
            split = answer.opened.split
            raise EvaluationError(f"{data}: split {split!r} has no ground truth that counts ({rules.text})")
        scores = tuple(replace(item, table=item.table.select(rows)) for item in answer.scores)
        found.append(replace(answer, scores=scores))
    return found
