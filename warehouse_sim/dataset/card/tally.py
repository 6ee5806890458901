"""What a dataset holds, in numbers that add up: taken while a scene is written, put together when all are.

A scene's tally lies in its record, so that the card of a dataset costs no second look at its images. Which objects look
alike is a digest of triangles and paint, not a name: a luminaire of the same name shines otherwise in another scene,
and several pallets are one shape.
"""

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Annotated, Any, Self

import numpy as np

from warehouse_sim.dataset.files.record import Name, Record, Whole
from warehouse_sim.ranges import Range
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, Observation, SceneSpec
from warehouse_sim.schema.things import is_damaged

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


def count_in_bins(values: Sequence[float], name: str) -> list[int]:
    """Return how many values lie in each of the ``BINS`` of that name; what lies beyond counts in the outer ones."""
    edges = BINS[name]
    counts: list[int] = np.histogram(np.clip(values, edges[0], edges[-1]), edges)[0].tolist()
    return counts


_Count = Annotated[int, Range(0, 2**53)]


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


def split_table(splits: Mapping[str, Tally]) -> dict[str, Any]:
    """Return, for each split, how many scenes, observations and labelled targets it has, and targets by bin.

    Args:
        splits: What each split holds.
    """
    return {"bins": {name: list(edges) for name, edges in BINS.items()}} | {
        name: {"scenes": held.scenes, "observations": held.observations, "targets": held.labels, **held.bins}
        for name, held in splits.items()
    }


@dataclass(frozen=True)
class _LookRow(Record):
    """One look and how often it occurs, as a scene's record holds it."""

    class_name: Name
    obj_id: Whole
    mesh: str
    look: str
    damaged: bool
    placed: _Count
    seen: _Count
    labels: _Count


@dataclass(frozen=True)
class TallyRecord(Record):
    """The tally of one scene, as its record holds it."""

    observations: Whole
    points: _Count
    bins: dict[str, tuple[_Count, ...]]
    looks: tuple[_LookRow, ...]

    def __post_init__(self) -> None:
        for name, edges in BINS.items():
            if len(self.bins.get(name, ())) != len(edges) - 1:
                raise ValueError(f"{name} must hold {len(edges) - 1} counts")

    @classmethod
    def of(cls, tally: Tally) -> Self:
        """Return what is stored of a tally."""
        looks = tuple(_LookRow(**vars(look), **vars(count)) for look, count in tally.looks.items())
        bins = {name: tuple(counts) for name, counts in tally.bins.items()}
        return cls(tally.observations, tally.points, bins, looks)

    def tally(self) -> Tally:
        """Return the tally that is stored."""
        looks = {
            Look(row.class_name, row.obj_id, row.mesh, row.look, row.damaged): LookCount(
                row.placed, row.seen, row.labels
            )
            for row in self.looks
        }
        bins = {name: list(self.bins[name]) for name in BINS}
        return Tally(1, self.observations, self.points, looks, bins)


class SceneTally:
    """Takes the tally of one scene while its observations go by.

    Args:
        scene: As it was drawn.
        paired_variants: Name and scene of each variant beside it.
    """

    def __init__(self, scene: SceneSpec, paired_variants: Sequence[tuple[str, SceneSpec]] = ()) -> None:
        self._scene, self._paired_variants = scene, dict(paired_variants)
        self._tally = Tally(scenes=1)
        self._seen: dict[str, set[int]] = {}
        self._labels: dict[str, Counter[int]] = {}

    def add(self, observation: Observation) -> None:
        """Count one observation."""
        variant = observation.conditions.variant if observation.conditions.variant in self._paired_variants else ""
        labelled = [item for item in observation.annotations if item.pixels_visible > 0]
        ids = np.flatnonzero(np.bincount(observation.buffers.instance_mask.ravel()))
        self._seen.setdefault(variant, set()).update(ids.tolist())
        self._labels.setdefault(variant, Counter()).update(item.instance_id for item in labelled)
        self._tally.observations += 1
        self._tally.points += 0 if observation.lidar is None else len(observation.lidar.points)
        values = {
            "visible_fraction": [item.visible_fraction for item in labelled],
            "distance": [float(np.linalg.norm(item.T_camera_object[:3, 3])) for item in labelled],
            "lux": [item.illuminance for item in labelled if item.illuminance is not None],
        }
        for name, found in values.items():
            counts = count_in_bins(found, name)
            self._tally.bins[name] = [a + b for a, b in zip(self._tally.bins[name], counts, strict=True)]

    def finish(self) -> Tally:
        """Return the tally, with what stands in the scene."""
        for variant, scene in {"": self._scene, **self._paired_variants}.items():
            seen, labels = self._seen.get(variant, set()), self._labels.get(variant, Counter())
            looks = looks_of(scene)
            for item in scene.instances:
                look, first = looks[item.instance_id], variant == ""
                if not first and item.instance_id not in seen:
                    continue
                count = self._tally.looks.setdefault(look, LookCount())
                count.placed += first
                count.seen += first and item.instance_id in seen
                count.labels += labels[item.instance_id]
        ordered = sorted(self._tally.looks, key=lambda look: (look.class_name, look.obj_id, look.mesh, look.look))
        self._tally.looks = {look: self._tally.looks[look] for look in ordered}
        return self._tally


_BYTES = 6
"""Of a digest: among a million of them, two are equal by chance once in 560 datasets."""


def looks_of(scene: SceneSpec) -> dict[int, Look]:
    """Return the look of each object of a scene by instance id."""
    meshes: dict[str, str] = {}
    looks: dict[object, Look] = {}
    found = {}
    for item in scene.instances:
        if item.look not in looks:
            model = scene.model_of(item)
            if item.model not in meshes:
                meshes[item.model] = _mesh_digest(model)
            mesh = meshes[item.model]
            paint = _look_digest(mesh, item, model, scene.materials)
            looks[item.look] = Look(model.class_name, model.obj_id, mesh, paint, is_damaged(item.model))
        found[item.instance_id] = looks[item.look]
    return found


def _mesh_digest(model: ObjectModel) -> str:
    digest = hashlib.blake2b(digest_size=_BYTES)
    for part in model.parts:
        for array in (part.mesh.vertices, part.mesh.faces, part.scale, part.T_object_part):
            digest.update(array.tobytes())
    return digest.hexdigest()


def _look_digest(mesh: str, item: ObjectInstance, model: ObjectModel, materials: Mapping[str, Material]) -> str:
    digest = hashlib.blake2b(mesh.encode(), digest_size=_BYTES)
    for part in model.parts:
        name = item.material_of(part)
        # A name says nothing of what the eye sees.
        seen = replace(materials[name], name="") if name in materials else name
        digest.update(repr(seen).encode())
    return digest.hexdigest()
