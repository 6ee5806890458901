"""The outer surface of a CAD mesh as samples on its triangles, without the faces that nothing outside can see."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial.transform import Rotation

from warehouse_sim.geometry.mesh import TriangleMesh

_CELLS = 32
"""Cells a side of the grid that finds the triangles above a point."""
_PAIRS = 2_000_000
"""Most pairs of a point and a triangle that are looked at together."""
_TURN = Rotation.from_rotvec([0.31, 0.77, -0.42]).as_matrix()
_DIRECTIONS = [np.roll(_TURN, axis, axis=0) for axis in range(3)]
"""Turns to three directions across each other that no face of a made object is parallel to."""


class Triangles:
    """Triangles that points are measured from, each with what does not depend on the point.

    Args:
        corners: Their corners. One without an area has no normal, and must not be measured from: no sample lies on it.
        normals: Their unit normals.
    """

    def __init__(self, corners: Float[np.ndarray, "m 3 3"], normals: Float[np.ndarray, "m 3"]) -> None:
        a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        d11, d12, d22 = dot(ab, ab), dot(ab, ac), dot(ac, ac)
        area = np.maximum(d11 * d22 - d12 * d12, 1e-24)[:, None]
        across = (d22[:, None] * ab - d12[:, None] * ac) / area, (d11[:, None] * ac - d12[:, None] * ab) / area
        self._planes = np.stack([a, *across, normals], axis=1)
        edges = np.roll(corners, -1, axis=1) - corners
        self._edges = np.stack([corners, edges, edges / np.maximum(dot(edges, edges), 1e-24)[..., None]], axis=1)

    def offset(
        self, points: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, " n"]
    ) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, " n"]]:
        """Return the vector to each point from the nearest point of its triangle, and the height over its plane.

        The foot on the plane where it falls inside the triangle (by barycentric coordinates), else the nearest point of
        the three edges.
        """
        plane = self._planes[faces]
        v, w, height = np.einsum("ni,nki->kn", points - plane[:, 0], plane[:, 1:])
        offset = height[:, None] * plane[:, 3]
        beside = np.flatnonzero((v < 0) | (w < 0) | (v + w > 1))
        corner, edge, along = np.moveaxis(self._edges[faces[beside]], 1, 0)
        rest = points[beside, None] - corner
        rest -= dot(rest, along).clip(0.0, 1.0)[..., None] * edge
        offset[beside] = rest[np.arange(len(beside)), dot(rest, rest).argmin(axis=1)]
        return offset, height


def inside(corners: Float[np.ndarray, "m 3 3"], points: Float[np.ndarray, "n 3"]) -> Bool[np.ndarray, " n"]:
    """Return which points lie inside any of the closed parts that the triangles ``corners`` bound.

    Parts may overlap or touch. A ray from the point leaves each part that the point lies in once more than it enters
    it; the majority of three directions decides, so that a small hole in a part does no harm.
    """
    one, other = (_exits_above(corners @ turn.T, points @ turn.T) > 0 for turn in _DIRECTIONS[:2])
    split = np.flatnonzero(one != other)
    one[split] = _exits_above(corners @ _DIRECTIONS[2].T, points[split] @ _DIRECTIONS[2].T) > 0
    return one


def dot(a: Float[np.ndarray, "*batch 3"], b: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch"]:
    """Return the scalar products of the last axis."""
    return np.einsum("...i,...i->...", a, b)


def _exits_above(corners: Float[np.ndarray, "m 3 3"], points: Float[np.ndarray, "n 3"]) -> Int[np.ndarray, " n"]:
    """Return how many parts more a ray along +z leaves than it enters."""
    low = corners[..., :2].min(axis=(0, 1))
    cell = (corners[..., :2].max(axis=(0, 1)) - low) / _CELLS + 1e-12
    first, order = _triangles_by_cell(((corners[..., :2] - low) / cell).astype(int).clip(0, _CELLS - 1))
    place = ((points[:, :2] - low) / cell).astype(int)
    covered = ((points[:, :2] >= low) & (place < _CELLS)).all(axis=1)
    number = np.where(covered, place[:, 0] * _CELLS + place[:, 1], 0)
    count = np.where(covered, np.diff(first)[number], 0)
    exits = np.zeros(len(points), dtype=int)
    for part in np.array_split(np.arange(len(points)), int(count.sum()) // _PAIRS + 1):
        point = np.repeat(part, count[part])
        rank = np.arange(len(point)) - np.repeat(np.cumsum(count[part]) - count[part], count[part])
        crossing = _crossings(corners[order[first[number[point]] + rank]], points[point])
        exits += np.bincount(point, weights=crossing, minlength=len(points)).astype(int)
    return exits


def _triangles_by_cell(place: Int[np.ndarray, "m 3 2"]) -> tuple[Int[np.ndarray, " cells+1"], Int[np.ndarray, " p"]]:
    """Return where each cell's triangles begin in a list, and the list, by the cells of the triangles' corners."""
    least, span = place.min(axis=1), np.ptp(place, axis=1) + 1
    triangle = np.repeat(np.arange(len(place)), span.prod(axis=1))
    rank = np.arange(len(triangle)) - np.repeat(np.cumsum(span.prod(axis=1)) - span.prod(axis=1), span.prod(axis=1))
    row, column = np.divmod(rank, span[triangle, 1])
    cell = (least[triangle, 0] + row) * _CELLS + least[triangle, 1] + column
    first = np.concatenate([[0], np.cumsum(np.bincount(cell, minlength=_CELLS**2))])
    return first, triangle[np.argsort(cell, kind="stable")]


def _crossings(corners: Float[np.ndarray, "p 3 3"], points: Float[np.ndarray, "p 3"]) -> Int[np.ndarray, " p"]:
    """Return 1 where the ray along +z leaves through the triangle, -1 where it enters, 0 where it misses."""
    offset = corners - points[:, None]
    x, y, z = np.moveaxis(offset, 2, 0)
    # Twice the signed areas of the three triangles with the point, in the plane across the ray.
    fraction = np.stack([x[:, i] * y[:, j] - x[:, j] * y[:, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
    sign = (fraction > 0).all(axis=1).astype(int) - (fraction < 0).all(axis=1)
    return np.where((fraction * z).sum(axis=1) * sign > 0, sign, 0)


# How far outside a face one looks to tell whether another part covers it (m).
_PROBE = 1e-3


@dataclass(frozen=True, eq=False)
class CadSurface:
    """Samples of the outer surface of one object, in its frame, and the triangles they lie on."""

    points: Float[np.ndarray, "k 3"]
    """Samples, uniform by area (m)."""
    faces: Int[np.ndarray, " k"]
    """Triangle of each sample."""
    rank: Float[np.ndarray, " k"]
    """A number 0-1 for each sample; those below p are a random share p of all."""
    corners: Float[np.ndarray, "m 3 3"]
    """Corners of all triangles (m)."""
    normals: Float[np.ndarray, "m 3"]
    """Unit outward normals of all triangles."""

    @cached_property
    def low(self) -> Float[np.ndarray, " 3"]:
        """Least coordinates of the samples (m)."""
        return self.points.min(axis=0)

    @cached_property
    def high(self) -> Float[np.ndarray, " 3"]:
        """Greatest coordinates of the samples (m)."""
        return self.points.max(axis=0)

    @cached_property
    def size(self) -> Float[np.ndarray, " 3"]:
        """Edge lengths of the box about the samples (m)."""
        return self.high - self.low

    @cached_property
    def moments(self) -> tuple[Float[np.ndarray, " 3"], Float[np.ndarray, "3 3"]]:
        """Mean (m) and covariance (m^2) of the samples."""
        return self.points.mean(axis=0), np.cov(self.points.T, bias=True)

    def thinned(self, count: int) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
        """Return about ``count`` of the samples, always the same ones, with their normals."""
        if count not in self._thinned:
            kept = self.rank < min(count / len(self.points), 1.0)
            self._thinned[count] = self.points[kept], self.normals[self.faces[kept]]
        return self._thinned[count]

    @cached_property
    def _thinned(self) -> dict[int, tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]]:
        """Return what ``thinned`` returned, by the count."""
        return {}


def seeded_surface(mesh: TriangleMesh, obj_id: int, seed: int, count: int = 20_000) -> CadSurface:
    """Return the surface of an object, the same for each number and seed; ``count`` as ``build_surface``."""
    vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)
    return _seeded_surface(vertices.tobytes(), faces.tobytes(), obj_id, seed, count)


@lru_cache(maxsize=64)
def _seeded_surface(vertices: bytes, faces: bytes, obj_id: int, seed: int, count: int) -> CadSurface:
    """Return the surface of a mesh by its content: estimators of one process share those of the same CAD."""
    mesh = TriangleMesh(np.frombuffer(vertices).reshape(-1, 3), np.frombuffer(faces, np.int64).reshape(-1, 3))
    return build_surface(mesh, count, np.random.default_rng([seed, obj_id]))


def seeded_surfaces(mesh_of: Callable[[int], TriangleMesh], seed: int) -> Callable[[int], CadSurface]:
    """Return what gives the surface of an object by its number; each is sampled once, when it is first requested."""
    return cache(lambda obj_id: seeded_surface(mesh_of(obj_id), obj_id, seed))


def build_surface(mesh: TriangleMesh, count: int, rng: np.random.Generator) -> CadSurface:
    """Sample ``count`` points of ``mesh`` by area and drop those covered by another part of it.

    Args:
        mesh: Closed parts that may touch or overlap (m, object frame).
        count: Samples before dropping.
        rng: Source of randomness.
    """
    areas, corners, normals = mesh.face_areas(), mesh.vertices[mesh.faces], mesh.face_normals()
    faces = rng.choice(len(areas), size=count, p=areas / areas.sum())
    r1, r2 = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
    a, b, c = np.moveaxis(corners[faces], 1, 0)
    points = (1 - r1) * a + r1 * (1 - r2) * b + r1 * r2 * c
    free = ~inside(corners, points + _PROBE * normals[faces])
    return CadSurface(points[free], faces[free], rng.random(int(free.sum())), corners, normals)
