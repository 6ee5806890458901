"""The outer surface of a CAD mesh as samples, without the faces that nothing outside can see."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.estimators.pose.icp.triangles import inside
from warehouse_sim.geometry.mesh import TriangleMesh

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
