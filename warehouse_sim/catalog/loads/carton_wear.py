"""Cartons that were dropped and squeezed: dents, crushed corners, bulging sides, in the mesh itself.

Board only ever goes inwards from the nominal box, so that a battered carton never reaches into its neighbour; it keeps
frame, size, mass and collision boxes. Print, tape and labels follow the board that they are on.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from jaxtyping import Float, Int, Int32

from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import invert, transform_points
from warehouse_sim.ranges import Fraction, Range, check_ranges
from warehouse_sim.schema import ObjectModel, Part

_FACET = 0.035
"""Longest edge of the triangles that board is bent in where it was hit (m)."""
_WIDE_FACET = 0.15
"""Longest edge elsewhere, where board only bulges (m)."""
_MOST_ROUNDS = 5
_SKIN_DEPTH = 0.03
"""How far below a side's surface a dent is still felt (m)."""

_PATTERNS = (
    [[0, 1, 2]],
    [[0, 3, 2], [3, 1, 2]],
    [[0, 3, 2], [3, 4, 2], [3, 1, 4]],
    [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
)
"""Triangles that remain of one with so many cut edges; corners 0-2, middles 3-5 of the edges 01, 12, 20."""

Points = Float[np.ndarray, "n 3"]


@dataclass(frozen=True)
class CartonWearConfig:
    """How cartons are battered."""

    fraction: Fraction = 0.0
    """Fraction of the cartons that are, 0-1."""
    depth: Annotated[float, Range(0.001, 0.06, "m")] = 0.02
    """Depth of the deepest dents and corners (m), 0.001-0.06."""
    bulge: Annotated[float, Range(0, 0.02, "m")] = 0.005
    """How far the edges of a side lie behind its middle at most (m), 0-0.02."""

    open_fraction: Fraction = 0.0
    """Fraction of the cartons up to 2.2 m that stand open or ajar where nothing is above them, 0-1."""

    def __post_init__(self) -> None:
        check_ranges(self)


def battered(model: ObjectModel, wear: CartonWearConfig, rng: np.random.Generator) -> ObjectModel:
    """Return ``model`` after rough handling, called ``<name>~<tag>``; its meaning is that of ``model``.

    Args:
        model: A carton whose outer faces are those of its box.
        wear: How much.
        rng: Stream to draw from; two draws give two cartons.
    """
    half = model.size / 2
    bulge = rng.uniform(0.0, wear.bulge)
    dents = [_Dent.sample(half, wear.depth, rng) for _ in range(int(rng.integers(1, 4)))]
    hits: list[_Dent | _Corner] = [*dents]
    hits += [_Corner.sample(half, wear.depth, rng) for _ in range(int(rng.integers(0, 3)))]

    def bent(points: Points) -> Points:
        moved = _bulged(points, half, bulge)
        for hit in hits:
            moved = moved + hit.shift(points)
        return np.clip(moved, -half, half)

    parts = tuple(_bent_part(part, bent, hits) for part in model.parts)
    return replace(model, name=f"{model.name}~{rng.integers(1 << 32):08x}", parts=parts)


@dataclass(frozen=True, eq=False)
class _Dent:
    """A hollow in one of the four sides."""

    axis: int
    sign: float
    place: Points
    radius: float
    depth: float

    @classmethod
    def sample(cls, half: np.ndarray, depth: float, rng: np.random.Generator) -> "_Dent":
        axis, sign = int(rng.integers(2)), float(rng.choice([-1.0, 1.0]))
        centre = half * rng.uniform(-0.9, 0.9, 3)
        centre[axis] = sign * half[axis]
        return cls(axis, sign, centre, rng.uniform(0.25, 0.7) * float(half.min() * 2), depth * rng.uniform(0.3, 1.0))

    def shift(self, points: Points) -> Points:
        away = points - self.place
        below = np.abs(away[:, self.axis])
        away[:, self.axis] = 0.0
        near = np.clip(1.0 - (away**2).sum(axis=1) / self.radius**2, 0.0, 1.0) ** 1.5
        move = np.zeros_like(points)
        move[:, self.axis] = -self.sign * self.depth * near * np.clip(1.0 - below / _SKIN_DEPTH, 0.0, 1.0)
        return move


@dataclass(frozen=True, eq=False)
class _Corner:
    """A dented corner."""

    place: Points
    radius: float
    depth: float

    @classmethod
    def sample(cls, half: np.ndarray, depth: float, rng: np.random.Generator) -> "_Corner":
        place = half * rng.choice([-1.0, 1.0], 3)
        return cls(place, rng.uniform(0.25, 0.6) * float(half.min() * 2), depth * rng.uniform(0.5, 1.5))

    def shift(self, points: Points) -> Points:
        near = np.clip(1.0 - np.linalg.norm(points - self.place, axis=1) / self.radius, 0.0, 1.0)
        return -(self.depth * near)[:, None] * np.sign(self.place)


def _bulged(points: Points, half: np.ndarray, depth: float) -> Points:
    """Return points of upright sides drawn in by up to ``depth`` (m) towards the sides' edges; lid and floor stay."""
    fraction = 1.0 - np.clip(points / half, -1.0, 1.0) ** 2
    moved = points.copy()
    for axis, across in ((0, 1), (1, 0)):
        behind = depth * (1.0 - fraction[:, across] * fraction[:, 2])
        moved[:, axis] *= 1.0 - behind / half[axis]
    return moved


def _bent_part(part: Part, bent: Callable[[Points], Points], hits: Sequence["_Dent | _Corner"]) -> Part:
    """Return ``part`` cut into small triangles and bent in the object's frame; its own frame stays."""
    fine = _cut(part.placed(), hits)
    vertices = transform_points(invert(part.T_object_part), bent(fine.vertices))
    return replace(part, mesh=TriangleMesh(vertices, fine.faces), scale=np.ones(3))


def _cut(mesh: TriangleMesh, hits: Sequence["_Dent | _Corner"]) -> TriangleMesh:
    """Return ``mesh`` with long edges halved, over and over, until the board can be bent in its triangles.

    An edge is cut for all its triangles or none, so that a closed mesh stays closed, and a thin strip is cut along its
    length alone; far from all ``hits`` triangles stay large.
    """
    for _ in range(_MOST_ROUNDS):
        ends = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).astype(np.int64)
        keys, number = np.unique(ends[..., 0] * len(mesh.vertices) + ends[..., 1], return_inverse=True)
        a, b = (mesh.vertices[end] for end in np.divmod(keys, len(mesh.vertices)))
        middle, length = (a + b) / 2, np.linalg.norm(a - b, axis=1)
        cut = length > _WIDE_FACET
        for hit in hits:
            near = np.linalg.norm(middle - hit.place, axis=1) < hit.radius + length / 2
            cut |= near & (length > _FACET)
        if not cut.any():
            break
        middles = np.where(cut, len(mesh.vertices) + np.cumsum(cut) - 1, -1)
        faces = _halved(mesh.faces, middles[number.reshape(-1, 3)])
        mesh = TriangleMesh(np.concatenate([mesh.vertices, middle[cut]]), faces)
    return mesh


def _halved(faces: Int[np.ndarray, "m 3"], middles: Int[np.ndarray, "m 3"]) -> Int32[np.ndarray, "k 3"]:
    """Return the triangles that remain when some edges are cut.

    Args:
        faces: Vertices a, b, c of each triangle.
        middles: Vertices in the middle of the edges ab, bc, ca; -1 where an edge stays whole.
    """
    count = (middles >= 0).sum(axis=1)
    # Turned so that the only cut edge comes first, or the only whole one last.
    turn = np.select([count == 1, count == 2], [(middles >= 0).argmax(axis=1), (middles < 0).argmax(axis=1) + 1], 0)
    order = (np.arange(3) + turn[:, None]) % 3
    corners = np.concatenate([np.take_along_axis(side, order, axis=1) for side in (faces, middles)], axis=1)
    cut = [corners[count == n][:, pattern].reshape(-1, 3) for n, pattern in enumerate(_PATTERNS)]
    return np.concatenate(cut).astype(np.int32)
