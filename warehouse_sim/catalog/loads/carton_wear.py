"""Cartons that were dropped and squeezed: dents, crushed corners, bulging sides, in the mesh itself.

Board only ever goes inwards from the nominal box, so that a battered carton never reaches into its neighbour; it keeps
frame, size, mass and collision boxes. Print, tape and labels follow the board that they are on.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import invert, transform_points
from warehouse_sim.ranges import Range, Share, check_ranges
from warehouse_sim.schema import ObjectModel, Part

_FACET = 0.035
"""Longest edge of the triangles that board is bent in (m)."""
_MOST_ROUNDS = 5
_SKIN_DEPTH = 0.03
"""How far below a side's surface a dent is still felt (m)."""

Points = Float[np.ndarray, "n 3"]


@dataclass(frozen=True)
class CartonWearConfig:
    """How cartons are battered."""

    share: Share = 0.0
    """Share of the cartons that are, 0-1."""
    depth: Annotated[float, Range(0.001, 0.06, "m")] = 0.02
    """Depth of the deepest dents and corners (m), 0.001-0.06."""
    bulge: Annotated[float, Range(0, 0.02, "m")] = 0.005
    """How far the edges of a side lie behind its middle at most (m), 0-0.02."""

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
    dents = [_Dent.draw(half, wear.depth, rng) for _ in range(int(rng.integers(1, 4)))]
    hits: list[_Dent | _Corner] = [*dents]
    hits += [_Corner.draw(half, wear.depth, rng) for _ in range(int(rng.integers(0, 3)))]

    def bent(points: Points) -> Points:
        moved = _bulged(points, half, bulge)
        for hit in hits:
            moved = moved + hit.shift(points)
        return np.clip(moved, -half, half)

    parts = tuple(_bent_part(part, bent) for part in model.parts)
    return replace(model, name=f"{model.name}~{rng.integers(1 << 32):08x}", parts=parts)


@dataclass(frozen=True, eq=False)
class _Dent:
    """A hollow in one of the four sides."""

    axis: int
    sign: float
    centre: Points
    radius: float
    depth: float

    @classmethod
    def draw(cls, half: np.ndarray, depth: float, rng: np.random.Generator) -> "_Dent":
        axis, sign = int(rng.integers(2)), float(rng.choice([-1.0, 1.0]))
        centre = half * rng.uniform(-0.9, 0.9, 3)
        centre[axis] = sign * half[axis]
        return cls(axis, sign, centre, rng.uniform(0.25, 0.7) * float(half.min() * 2), depth * rng.uniform(0.3, 1.0))

    def shift(self, points: Points) -> Points:
        away = points - self.centre
        below = np.abs(away[:, self.axis])
        away[:, self.axis] = 0.0
        near = np.clip(1.0 - (away**2).sum(axis=1) / self.radius**2, 0.0, 1.0) ** 1.5
        move = np.zeros_like(points)
        move[:, self.axis] = -self.sign * self.depth * near * np.clip(1.0 - below / _SKIN_DEPTH, 0.0, 1.0)
        return move


@dataclass(frozen=True, eq=False)
class _Corner:
    """A corner that was knocked in."""

    place: Points
    radius: float
    depth: float

    @classmethod
    def draw(cls, half: np.ndarray, depth: float, rng: np.random.Generator) -> "_Corner":
        place = half * rng.choice([-1.0, 1.0], 3)
        return cls(place, rng.uniform(0.25, 0.6) * float(half.min() * 2), depth * rng.uniform(0.5, 1.5))

    def shift(self, points: Points) -> Points:
        near = np.clip(1.0 - np.linalg.norm(points - self.place, axis=1) / self.radius, 0.0, 1.0)
        return -(self.depth * near)[:, None] * np.sign(self.place)


def _bulged(points: Points, half: np.ndarray, depth: float) -> Points:
    """Return points of upright sides drawn in by up to ``depth`` (m) towards the sides' edges; lid and floor stay."""
    share = 1.0 - np.clip(points / half, -1.0, 1.0) ** 2
    moved = points.copy()
    for axis, across in ((0, 1), (1, 0)):
        behind = depth * (1.0 - share[:, across] * share[:, 2])
        moved[:, axis] *= 1.0 - behind / half[axis]
    return moved


def _bent_part(part: Part, bent: Callable[[Points], Points]) -> Part:
    """Return ``part`` cut into small triangles and bent in the object's frame; its own frame stays."""
    fine = _cut(TriangleMesh(part.mesh.vertices * part.scale, part.mesh.faces))
    placed = bent(transform_points(part.T_object_part, fine.vertices))
    return replace(
        part, mesh=TriangleMesh(transform_points(invert(part.T_object_part), placed), fine.faces), scale=np.ones(3)
    )


def _cut(mesh: TriangleMesh) -> TriangleMesh:
    """Return ``mesh`` with every triangle cut in four, over and over, until none is too large."""
    for _ in range(_MOST_ROUNDS):
        corners = mesh.vertices[mesh.faces]
        if np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max() <= _FACET:
            break
        edges = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        known, number = np.unique(edges, axis=0, return_inverse=True)
        a, b, c = mesh.faces.T
        ab, bc, ca = (len(mesh.vertices) + number.reshape(-1, 3)).T
        faces = np.stack([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]).transpose(2, 0, 1).reshape(-1, 3)
        mesh = TriangleMesh(np.concatenate([mesh.vertices, mesh.vertices[known].mean(axis=1)]), faces.astype(np.int32))
    return mesh
