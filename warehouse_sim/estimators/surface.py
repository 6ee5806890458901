"""A CAD surface that can be asked for its nearest point, without the faces that nothing outside can see."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import cKDTree

from warehouse_sim.geometry.mesh import TriangleMesh

# How far outside a face one looks to tell whether another part covers it (m).
_PROBE = 1e-3
_CANDIDATES = 2
_CHUNK = 30_000


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

    def seen_from(self, eye: Float[np.ndarray, " 3"], squash: float) -> "SeenSurface":
        """Return the part whose outer side is turned to ``eye``, for depth readings of limited precision.

        Args:
            eye: Camera centre in the object frame (m).
            squash: Noise across the viewing direction over noise along it, 0-1.
        """
        view = eye / np.linalg.norm(eye)
        metric = np.eye(3) - (1.0 - squash) * np.outer(view, view)
        # Planes map by the inverse of the metric, areas by the length of the normal so mapped.
        normals = self.normals @ np.linalg.inv(metric)
        stretch = np.linalg.norm(normals, axis=1)
        towards = _dot(eye - self.corners[:, 0], self.normals) > 0
        # Thinned so that samples stay uniform by area: else squashed faces, more densely covered, would attract.
        kept = self.rank < np.where(towards, squash * stretch, 0.0)[self.faces]
        normals = normals / np.maximum(stretch, 1e-12)[:, None]
        return SeenSurface(self.points[kept] @ metric, self.faces[kept], self.corners @ metric, normals, metric)


class SeenSurface:
    """Nearest-point queries in a space squashed along the viewing direction.

    A depth reading errs along its ray far more than across it. Squashed by the ratio, its error is the same in all
    directions, and the nearest point of the surface is the most likely one.

    Args:
        points: Samples that face the camera (squashed).
        faces: Triangle of each.
        corners: Corners of all triangles (squashed).
        normals: Unit normals of all triangles (squashed).
        metric: Symmetric matrix that squashes the object frame.
    """

    def __init__(
        self,
        points: Float[np.ndarray, "k 3"],
        faces: Int[np.ndarray, " k"],
        corners: Float[np.ndarray, "m 3 3"],
        normals: Float[np.ndarray, "m 3"],
        metric: Float[np.ndarray, "3 3"],
    ) -> None:
        self._faces, self._corners, self._normals, self._metric = faces, corners, normals, metric
        # The tree serves for a few queries only: building it fast matters more than balance.
        self._tree = cKDTree(points, balanced_tree=False, compact_nodes=False)

    def nearest(self, points: Float[np.ndarray, "n 3"]) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n 3"]]:
        """Return the signed squashed distance (m) of points in the object frame, and its gradient there.

        In front of a triangle the distance grows along its normal; beside all of them, away from the nearest edge.
        """
        points = points @ self._metric
        _, near = self._tree.query(points, k=_CANDIDATES)
        faces = self._faces[near.ravel()]
        offset = np.repeat(points, _CANDIDATES, axis=0)
        offset -= closest_points(offset, self._corners[faces])
        best = _dot(offset, offset).reshape(-1, _CANDIDATES).argmin(axis=1) + _CANDIDATES * np.arange(len(points))
        offset, normal = offset[best], self._normals[faces[best]]
        distance, height = np.sqrt(_dot(offset, offset)), _dot(offset, normal)
        above = np.abs(height) >= 0.999 * distance
        direction = np.where(above[:, None], normal, offset / np.maximum(distance, 1e-9)[:, None])
        return np.where(above, height, distance), direction @ self._metric


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


def inside(corners: Float[np.ndarray, "m 3 3"], points: Float[np.ndarray, "n 3"]) -> Bool[np.ndarray, " n"]:
    """Return which points lie inside any of the closed parts that the triangles ``corners`` bound.

    By the generalised winding number (Jacobson et al., SIGGRAPH 2013), summing solid angles after Van Oosterom and
    Strackee, "The solid angle of a plane triangle", IEEE TBME 30(2), 1983; parts may overlap or touch.
    """
    block = max(1, _CHUNK // len(corners))
    parts = [_winding_number(corners, points[start : start + block]) for start in range(0, len(points), block)]
    return np.concatenate(parts) > 0.5


def _winding_number(corners: Float[np.ndarray, "m 3 3"], points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, " n"]:
    a, b, c = np.moveaxis(corners[None] - points[:, None, None], 2, 0)
    length_a, length_b, length_c = (np.linalg.norm(edge, axis=-1) for edge in (a, b, c))
    volume = (a * np.cross(b, c)).sum(axis=-1)
    dots = length_a * length_b * length_c
    dots += (a * b).sum(-1) * length_c + (b * c).sum(-1) * length_a + (c * a).sum(-1) * length_b
    return np.arctan2(volume, dots).sum(axis=1) / (2.0 * np.pi)


def closest_points(points: Float[np.ndarray, "n 3"], corners: Float[np.ndarray, "n 3 3"]) -> Float[np.ndarray, "n 3"]:
    """Return the point of each triangle that is nearest to each point.

    The foot on the plane where it falls inside the triangle (by barycentric coordinates), else the nearest point of
    the three edges.
    """
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    ap = points - a
    d11, d12, d22, p1, p2 = _dot(ab, ab), _dot(ab, ac), _dot(ac, ac), _dot(ap, ab), _dot(ap, ac)
    area = np.maximum(d11 * d22 - d12 * d12, 1e-24)
    v, w = (d22 * p1 - d12 * p2) / area, (d11 * p2 - d12 * p1) / area
    closest = a + v[:, None] * ab + w[:, None] * ac
    beside = np.flatnonzero((v < 0) | (w < 0) | (v + w > 1))
    closest[beside] = _closest_on_edges(points[beside], corners[beside])
    return closest


def _closest_on_edges(
    points: Float[np.ndarray, "n 3"], corners: Float[np.ndarray, "n 3 3"]
) -> Float[np.ndarray, "n 3"]:
    edges = np.roll(corners, -1, axis=1) - corners
    offset = points[:, None] - corners
    share = np.clip(_dot(offset, edges) / np.maximum(_dot(edges, edges), 1e-24), 0.0, 1.0)
    rest = offset - share[..., None] * edges
    nearest = _dot(rest, rest).argmin(axis=1)
    return points - rest[np.arange(len(points)), nearest]


def _dot(a: Float[np.ndarray, "*batch 3"], b: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch"]:
    return np.einsum("...i,...i->...", a, b)
