"""What a dataset holds, in numbers that add up: taken while a scene is written, put together when all are.

A scene's tally lies in its record, so that the card of a dataset costs no second look at its images.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from warehouse_sim.dataset.files.plain import WHOLE, Span, take, take_name
from warehouse_sim.dataset.split_table import BINS
from warehouse_sim.errors import DatasetError

_COUNTS = Span(0, 2**53)


@dataclass(frozen=True)
class Look:
    """One surface with its paint."""

    class_name: str
    obj_id: int
    """Number of the CAD geometry, that of the undamaged type for a damaged object."""
    mesh: str
    """Digest of the triangles; objects that are equal in shape have the same."""
    look: str
    """Digest of the triangles and of what each part is painted with."""
    damaged: bool
    """Whether the triangles are those of a damaged object."""


@dataclass
class LookCount:
    """How often one look occurs."""

    placed: int = 0
    """Objects that have it, in scenes as they were drawn: those of paired variants are not counted again."""
    seen: int = 0
    """Of those objects, how many have a pixel in an image."""
    labels: int = 0
    """Labels of such objects in all images, paired variants' included."""


@dataclass
class Tally:
    """Counts of one scene, or of many."""

    scenes: int = 0
    observations: int = 0
    points: int = 0
    """Of all sweeps of the main LiDAR."""
    looks: dict[Look, LookCount] = field(default_factory=dict)
    bins: dict[str, list[int]] = field(default_factory=lambda: {name: [0] * (len(BINS[name]) - 1) for name in BINS})
    """Labels by visible fraction, distance and lux: the bins of the split table."""

    def add(self, other: "Tally") -> None:
        """Add the counts of another tally."""
        self.scenes += other.scenes
        self.observations += other.observations
        self.points += other.points
        for look, count in other.looks.items():
            own = self.looks.setdefault(look, LookCount())
            own.placed += count.placed
            own.seen += count.seen
            own.labels += count.labels
        for name, counts in other.bins.items():
            self.bins[name] = [a + b for a, b in zip(self.bins[name], counts, strict=True)]

    @property
    def labels(self) -> int:
        """Number of all labels."""
        return sum(count.labels for count in self.looks.values())


def tally_row(tally: Tally) -> dict[str, Any]:
    """Return a scene's tally as plain data for its record."""
    looks = [
        {**vars(look), **vars(tally.looks[look])}
        for look in sorted(tally.looks, key=lambda look: (look.class_name, look.obj_id, look.mesh, look.look))
    ]
    return {"observations": tally.observations, "points": tally.points, "bins": tally.bins, "looks": looks}


def read_tally(data: Mapping[str, Any], where: str) -> Tally:
    """Read the tally of one scene.

    Raises:
        DatasetError: An entry is missing or malformed.
    """
    bins = take(data, "bins", dict, where)
    looks = {}
    for number, row in enumerate(take(data, "looks", list, where)):
        inner = f"{where}: looks[{number}]"
        look = Look(
            take_name(row, "class_name", inner),
            take(row, "obj_id", int, inner, WHOLE),
            take(row, "mesh", str, inner),
            take(row, "look", str, inner),
            take(row, "damaged", bool, inner),
        )
        looks[look] = LookCount(*(take(row, key, int, inner, _COUNTS) for key in ("placed", "seen", "labels")))
    return Tally(
        scenes=1,
        observations=take(data, "observations", int, where, WHOLE),
        points=take(data, "points", int, where, _COUNTS),
        looks=looks,
        bins={name: _read_bins(bins, name, f"{where}: bins") for name in BINS},
    )


def _read_bins(data: dict[str, Any], name: str, where: str) -> list[int]:
    counts = take(data, name, list, where)
    if len(counts) != len(BINS[name]) - 1 or not all(type(count) is int and count in _COUNTS for count in counts):
        raise DatasetError(f"{where}: {name} must hold {len(BINS[name]) - 1} counts")
    return counts
