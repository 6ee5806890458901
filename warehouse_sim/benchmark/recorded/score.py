"""Recorded frames in plain folders: what of them can be scored, and the score of those with labelled fronts."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from warehouse_sim.benchmark.entrants.entrant import Asked, Group, Shuffled, Truth
from warehouse_sim.benchmark.recorded.entries import GRAVITY, MASKS, TRIVIAL, entries
from warehouse_sim.benchmark.recorded.fronts import Entry, RecordedFront, drive_in, read_fronts
from warehouse_sim.benchmark.rows.row import Row
from warehouse_sim.benchmark.rows.scores import DRAWS
from warehouse_sim.benchmark.scored import posed_split
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import DatasetError, InputError
from warehouse_sim.evaluation.docking.fork import ForkConfig
from warehouse_sim.evaluation.intervals import share_interval


@dataclass(frozen=True)
class Recorded:
    """One folder of recorded frames."""

    path: Path
    kind: Literal["fronts", "posed", "other"]
    note: str = ""
    """Why nothing of it is scored."""
    split: str = ""
    """Which has poses."""


def find_recorded(data: Path) -> list[Recorded]:
    """Return what lies in a folder and in those within it.

    ``fronts`` has sites with ``labels.json``, ``posed`` is a folder in a known format with poses; of all else the note
    says why it is not scored.

    Raises:
        InputError: It is no folder.
    """
    if not data.is_dir():
        raise InputError(f"{data}: is no folder of recorded frames")
    if _has_fronts(data):
        return [_recorded(data)]
    # A folder that holds one called kitti is read as KITTI's: what lies in it comes first.
    within = [_recorded(path) for path in sorted(data.iterdir()) if path.is_dir()]
    return within if any(item.kind != "other" for item in within) else [_recorded(data)]


def _has_fronts(path: Path) -> bool:
    return (path / "labels.json").is_file() or any(path.glob("*/labels.json"))


def _recorded(path: Path) -> Recorded:
    if _has_fronts(path):
        return Recorded(path, "fronts")
    try:
        reader = DatasetReader(path)
        split = posed_split(reader)
        images = [image for name in reader.splits for image in reader.images(name)]
    except DatasetError as problem:
        reason = str(problem).replace(str(path), path.name)
        return Recorded(path, "other", f"{path.name}: not in a format that is read ({reason})")
    if split:
        return Recorded(path, "posed", split=split)
    masks = sum(len(image.targets) for image in images)
    what = f"{len(images)} images, {masks} masks, no poses to score against"
    return Recorded(path, "other", f"{path.name}: {what}; predict and inspect take it")


def trivial_group() -> Group:
    """Return the trivial method for fronts, which answers without an estimator."""
    return Group(TRIVIAL, (Truth(TRIVIAL),))


def front_rows(group: Group, folder: Path) -> Iterator[Row]:
    """Yield the share of recorded fronts that a fork enters that trusts an estimator, by masks and gravity.

    Truth is the labels, shuffled the label of a frame of another site. A front without an answer is not entered.

    Raises:
        InputError: The labels are malformed, or the estimator answers none of the fronts: their pallets are in no
            catalog, and it must say where pockets are by itself.
        DatasetError: An image cannot be read.
    """
    fronts = read_fronts(folder)
    sites = np.unique([front.name.rpartition("/")[0] for front in fronts], return_inverse=True)[1]
    member = group.members[0]
    for masks in MASKS:
        for gravity in GRAVITY:
            found = _entries(group, fronts, masks, gravity)
            if isinstance(member, Asked) and all(item is None for item in found):
                raise InputError(f"{group.name} answers none of the fronts: their pallets are in no catalog")
            values = np.array([item is not None and item.docked for item in found], dtype=float)
            low, high = share_interval(values, sites, DRAWS, np.random.default_rng(0))
            value = float(values.mean())
            interval = round(min(low, value), 5), round(max(high, value), 5)
            condition = f"{folder.name}, masks: {masks}, gravity: {gravity}"
            counted = len(values), int(sites.max()) + 1
            yield Row(
                "fronts", group.name, condition, "all", "docked", round(value, 5), interval, *counted, group.trainings
            )


def _as_elsewhere(front: RecordedFront, fronts: Sequence[RecordedFront]) -> Entry | None:
    """Return what a fork does that takes a front for one of another site, in turn; None where there is one site.

    Frames of one site follow each other: the truck has hardly moved.
    """
    site = front.name.rpartition("/")[0]
    others = [item for item in fronts if item.name.rpartition("/")[0] != site]
    if not others:
        return None
    other = others[fronts.index(front) % len(others)]
    return drive_in(front, other.T_camera_dock, list(other.pockets[:, 1:]), ForkConfig())


def _entries(group: Group, fronts: Sequence[RecordedFront], masks: str, gravity: str) -> list[Entry | None]:
    member = group.members[0]
    if group.name == TRIVIAL:
        return entries(None, {}, fronts, masks, gravity)
    if isinstance(member, Truth):
        return [drive_in(front, front.T_camera_dock, list(front.pockets[:, 1:]), ForkConfig()) for front in fronts]
    if isinstance(member, Shuffled):
        return [_as_elsewhere(front, fronts) for front in fronts]
    if not isinstance(member, Asked):
        raise InputError(f"{group.name}: files of poses say nothing of fronts; name an estimator")
    return entries(member.way.open({}), {}, fronts, masks, gravity)
