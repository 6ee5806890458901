"""Groups of ground truths that tables have a row for: by class, distance, points of a LiDAR, paired variant."""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise, product
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.evaluation.docking.standing import Standings
from warehouse_sim.evaluation.error_table import ErrorTable
from warehouse_sim.evaluation.measuring import measure
from warehouse_sim.ranges import Fraction, Range, ranged

_JOINED = " x "
SUBSET = 60
"""Pallets of a layout on which methods that take long are scored, too."""
Place = tuple[int, int, int]
"""Scene, image, position among its labels."""
Rows = Bool[np.ndarray, " n"]


@dataclass(frozen=True)
@ranged
class EdgeConfig:
    """Where bins begin; the last of distance and visible fraction ends them."""

    distance: tuple[Annotated[float, Range(0, 100_000, "m")], ...] = (0.0, 2.0, 7.0, 15.0, 25.0, 35.0)
    """Of the distance (m), rising, 0-100,000."""
    visible_fraction: tuple[Fraction, ...] = (0.1, 0.3, 0.5, 0.7, 0.9, 1.0)
    """Of the visible fraction, rising, 0-1; what is seen as a whole is in the last."""
    lidar_points: tuple[Annotated[int, Range(0, 1_000_000_000)], ...] = (0, 50, 100)
    """Least numbers of LiDAR points, rising, 0-1,000,000,000; groups hold one another."""

    def __post_init__(self) -> None:
        for name in ("distance", "visible_fraction", "lidar_points"):
            edges = getattr(self, name)
            if not edges or any(not low < high for low, high in pairwise(edges)):
                raise ValueError(f"{name} must rise, found {list(edges)}")


@dataclass(frozen=True, eq=False)
class Subjects:
    """Ground truths of a dataset, and what a score does not say of them."""

    table: ErrorTable
    edges: EdgeConfig = field(default_factory=EdgeConfig)
    variants: tuple[str, ...] = ()
    """Name of the variant of each observation of a scene; empty without paired variants."""
    lidar_points: Mapping[Place, int] = field(default_factory=dict)
    """How many points of the sweep are on each."""


def places_of(table: ErrorTable) -> list[Place]:
    """Return scene, image and position of each row."""
    columns = table.scene_id, table.image_id, table.gt_index
    return list(zip(*(column.tolist() for column in columns), strict=True))


def ground_truths(reader: DatasetReader, split: str) -> ErrorTable:
    """Return the rows of a split in which nothing is found: what is counted, and what of it a truck can take."""
    images = reader.images(split)
    return measure((), images, reader.objects, standings=Standings.of(reader, images))


def fixed_subset(table: ErrorTable) -> Rows:
    """Return ``SUBSET`` of the pallets that docking is evaluated of, or all where there are less, by hash.

    The hash is of scene, image and position, so that everybody is scored on the same, whatever it estimates.
    """
    can = np.flatnonzero(table.evaluated())
    places = places_of(table)
    order = sorted(can.tolist(), key=lambda row: hashlib.sha256(repr(places[row]).encode()).digest())
    chosen = np.zeros(len(table), dtype=bool)
    chosen[order[:SUBSET]] = True
    return chosen


def split_name(grouping: str) -> list[str]:
    """Return the groupings that a name joins."""
    return grouping.split(_JOINED)


def groups(subjects: Subjects, grouping: str) -> Iterator[tuple[str, Rows]]:
    """Yield label and rows of every group of a grouping that holds anything."""
    parts = [list(GROUPINGS[name](subjects)) for name in split_name(grouping)]
    for chosen in product(*parts):
        rows = np.logical_and.reduce([rows for _, rows in chosen])
        if rows.any():
            yield ", ".join(label for label, _ in chosen), rows


def all_groups(subjects: Subjects, groupings: Sequence[str]) -> Iterator[tuple[str, Rows]]:
    """Yield the groups of several groupings, each label once: objects of others may be called as their class."""
    seen = set[str]()
    for grouping in groupings:
        for label, rows in groups(subjects, grouping):
            if label not in seen:
                seen.add(label)
                yield label, rows


def lidar_points(reader: DatasetReader, split: str) -> dict[Place, int]:
    """Count the points of the main LiDAR on each target of a split, by the ids of the sweep.

    A target without CAD has the points in its box for a model; those are counted. Without sweeps it is empty.
    """
    found: dict[Place, int] = {}
    for image in reader.images(split):
        mounted = None
        for target in image.targets:
            place = image.scene_id, image.image_id, target.gt_index
            if target.geometry is not None and not target.geometry.has_cad:
                found[place] = len(target.geometry.model_points())
                continue
            mounted = mounted or reader.sweep(image)
            if mounted is None:
                return {}
            found[place] = int((mounted.reading.instance_ids == target.instance_id).sum())
    return found


def _all(subjects: Subjects) -> Iterator[tuple[str, Rows]]:
    yield "all", np.ones(len(subjects.table), dtype=bool)


def _named(names: np.ndarray) -> Iterator[tuple[str, Rows]]:
    for name in sorted(set(names.tolist())):
        yield name, names == name


def _visible_fraction(subjects: Subjects) -> Iterator[tuple[str, Rows]]:
    edges = subjects.edges.visible_fraction
    yield from _bins(np.minimum(subjects.table.visible_fraction, np.nextafter(edges[-1], 0.0)), edges, " visible")


def _bins(values: Float[np.ndarray, " n"], edges: tuple[float, ...], unit: str) -> Iterator[tuple[str, Rows]]:
    for low, high in pairwise(edges):
        yield f"{low:g}-{high:g}{unit}", (values >= low) & (values < high)


def _lidar_points(subjects: Subjects) -> Iterator[tuple[str, Rows]]:
    counted = np.array([subjects.lidar_points.get(place, -1) for place in places_of(subjects.table)])
    for least in subjects.edges.lidar_points:
        label = f"at least {least} points" if least else "any number of points"
        yield label, (counted >= least) if least else np.ones(len(counted), dtype=bool)


def _variant(subjects: Subjects) -> Iterator[tuple[str, Rows]]:
    names = np.array(subjects.variants or ("base",))
    of_row = names[subjects.table.image_id % len(names)]
    for name in dict.fromkeys(names.tolist()):
        yield name, of_row == name


def _stacking(subjects: Subjects) -> Iterator[tuple[str, Rows]]:
    yield "alone", subjects.table.stacked == 0
    yield "stacked", subjects.table.stacked == 1


def _fixed_subset(subjects: Subjects) -> Iterator[tuple[str, Rows]]:
    yield "fixed subset", fixed_subset(subjects.table)


GROUPINGS: dict[str, Callable[[Subjects], Iterator[tuple[str, Rows]]]] = {
    "all": _all,
    "class": lambda subjects: _named(subjects.table.class_name),
    "object": lambda subjects: _named(subjects.table.object_name),
    "distance": lambda subjects: _bins(subjects.table.distance, subjects.edges.distance, " m"),
    "visible_fraction": _visible_fraction,
    "lidar_points": _lidar_points,
    "variant": _variant,
    "stacking": _stacking,
    "fixed subset": _fixed_subset,
}
"""From ground truths to label and rows of each group."""
