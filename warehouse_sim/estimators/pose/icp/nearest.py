"""The nearest points of CAD surfaces: exact on what faces a camera, or from a table of cells, which is faster."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int, UInt16
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from warehouse_sim.estimators.pose.icp.surface import CadSurface, Triangles, dot

_CANDIDATES = 2
_THREADS = 2
# Objects lie this far apart in the common tree (m), so that none finds another's surface.
_APART = 1e6


class VisibleSurfaces:
    """The sides of b objects that are turned to the camera, in a space scaled along the viewing direction.

    A depth reading errs along its ray far more than across it. Scaled by the ratio, its error is the same in all
    directions, and the nearest point of the surface is the most likely one.

    Args:
        surfaces: One an object.
        eyes: Camera centres in the object frames (m).
        anisotropy: Noise across the viewing direction over noise along it, 0-1, of each object.
        fraction: Fraction of the samples that are used, 0-1; what lies between them is found less surely.
    """

    def __init__(
        self,
        surfaces: Sequence[CadSurface],
        eyes: Float[np.ndarray, "b 3"],
        anisotropy: Float[np.ndarray, " b"],
        fraction: float = 1.0,
    ) -> None:
        views = eyes / np.linalg.norm(eyes, axis=1, keepdims=True)
        outer = views[:, :, None] * views[:, None]
        self._metric = np.eye(3) - (1.0 - anisotropy)[:, None, None] * outer
        # Planes map by the inverse of the metric, areas by the length of the normal so mapped.
        inverse = np.eye(3) + (1.0 / anisotropy - 1.0)[:, None, None] * outer
        self._first = np.cumsum([0] + [len(surface.corners) for surface in surfaces[:-1]])
        normals = [surface.normals @ matrix for surface, matrix in zip(surfaces, inverse, strict=True)]
        stretch = [np.linalg.norm(normal, axis=1) for normal in normals]
        points, faces = [], []
        for i, surface in enumerate(surfaces):
            towards = dot(eyes[i] - surface.corners[:, 0], surface.normals) > 0
            # Thinned so that samples stay uniform by area: else scaled faces, more densely covered, would attract.
            kept = surface.rank < np.where(towards, fraction * anisotropy[i] * stretch[i], 0.0)[surface.faces]
            if not kept.any():  # the camera is inside the object, or a pose far off says so
                kept = np.ones(len(surface.rank), dtype=bool)
            points.append(surface.points[kept] @ self._metric[i] + [i * _APART, 0.0, 0.0])
            faces.append(surface.faces[kept] + self._first[i])
        self.faces: Int[np.ndarray, " k"] = np.concatenate(faces)
        """Triangle of each point that is kept, counted over all objects."""
        self._normals = np.concatenate(normals) / np.maximum(np.concatenate(stretch), 1e-12)[:, None]
        corners = [surface.corners @ matrix for surface, matrix in zip(surfaces, self._metric, strict=True)]
        self._triangles = Triangles(np.concatenate(corners), self._normals)
        # The tree serves for a few queries only: building it fast matters more than balance.
        self._tree = cKDTree(np.concatenate(points), balanced_tree=False)

    def nearest(
        self, points: Float[np.ndarray, "b n 3"]
    ) -> tuple[Float[np.ndarray, "b n"], Float[np.ndarray, "b n 3"]]:
        """Return the signed scaled distance (m) of points in the object frames, and its gradient there.

        In front of a triangle the distance grows along its normal; beside all of them, away from the nearest edge.
        """
        batch, count, _ = points.shape
        scaled = points @ self._metric
        apart = np.arange(batch)[:, None, None] * np.array([_APART, 0.0, 0.0])
        _, near = self._tree.query((scaled + apart).reshape(-1, 3), k=_CANDIDATES, workers=_THREADS)
        faces = self.faces[near.ravel()]
        offset, height = self._triangles.offset(np.repeat(scaled.reshape(-1, 3), _CANDIDATES, axis=0), faces)
        square = dot(offset, offset)
        rows = _CANDIDATES * np.arange(batch * count)
        best = square.reshape(-1, _CANDIDATES).argmin(axis=1) + rows
        offset, normal, height, distance = offset[best], self._normals[faces[best]], height[best], np.sqrt(square[best])
        above = np.abs(height) >= 0.999 * distance
        direction = np.where(above[:, None], normal, offset / np.maximum(distance, 1e-9)[:, None])
        return np.where(above, height, distance).reshape(batch, count), direction.reshape(points.shape) @ self._metric


_TABLE_CELLS = 80
"""Cells along an object's longest edge: about as wide as the samples are apart."""
_MARGIN = 6
"""Cells around the object's box; what lies beyond is taken for what lies at their border."""
_HIDDEN = -0.3
"""Scalar product of a normal and the signs of an octant below which no camera in the octant sees the face."""
_BESIDE = 2.0
"""A point is beside a surface when its foot on the plane is so many cells away from the nearest sample."""


class SurfaceCells:
    """Which sample is nearest to each cell of the space around an object, for cameras in each of its octants.

    Args:
        surface: CAD surface of the object; at most 65,536 samples.
    """

    def __init__(self, surface: CadSurface) -> None:
        self.surface = surface
        self.step = float(surface.size.max()) / _TABLE_CELLS
        """Edge length of a cell (m)."""
        self.origin: Float[np.ndarray, " 3"] = surface.low - _MARGIN * self.step
        """Corner of the first cell (object frame, m)."""
        self.shape: Int[np.ndarray, " 3"] = np.ceil(surface.size / self.step).astype(int) + 2 * _MARGIN
        """Number of cells along each axis."""
        self._tables: dict[int, UInt16[np.ndarray, " cells"]] = {}

    @cached_property
    def middle(self) -> Float[np.ndarray, " 3"]:
        """Middle of the object's box (m), about which octants are counted."""
        return (self.surface.low + self.surface.high) / 2.0

    def octants(self, eyes: Float[np.ndarray, "b 3"]) -> Int[np.ndarray, " b"]:
        """Return the number of the octant that each camera centre (object frame, m) is in, 0-7."""
        return ((eyes > self.middle) @ np.array([1, 2, 4])).astype(int)

    def samples_near(
        self, points: Float[np.ndarray, "b n 3"], octants: Int[np.ndarray, " b"]
    ) -> UInt16[np.ndarray, "b n"]:
        """Return the number of the sample nearest to each point (object frame, m), about."""
        place = ((points - self.origin) / self.step).astype(int)
        x, y, z = (place[..., axis].clip(0, self.shape[axis] - 1) for axis in range(3))
        cells = (x * self.shape[1] + y) * self.shape[2] + z
        found = np.empty(cells.shape, dtype=np.uint16)
        for octant in np.unique(octants):
            rows = octants == octant
            found[rows] = self._table(int(octant))[cells[rows]]
        return found

    def _table(self, octant: int) -> UInt16[np.ndarray, " cells"]:
        if octant not in self._tables:
            self._tables[octant] = self._filled(octant)
        return self._tables[octant]

    def _filled(self, octant: int) -> UInt16[np.ndarray, " cells"]:
        surface = self.surface
        signs = np.where(np.array([octant & 1, octant & 2, octant & 4]) > 0, 1.0, -1.0)
        seen = np.flatnonzero((surface.normals @ signs > _HIDDEN)[surface.faces])
        place = ((surface.points[seen] - self.origin) / self.step).astype(int)
        table = np.full(tuple(self.shape), -1, dtype=np.int32)
        # In falling order of their ranks: of the samples of a cell the last one written stays, a random one.
        order = np.argsort(-surface.rank[seen], kind="stable")
        table[tuple(place[order].T)] = seen[order]
        nearest = distance_transform_edt(table < 0, return_distances=False, return_indices=True)
        return table[tuple(nearest)].astype(np.uint16).ravel()


class NearestByCell:
    """The sides of b objects that are turned to the camera.

    Args:
        cells: One an object; equal ones stand together.
        eyes: Camera centres in the object frames (m).
    """

    def __init__(self, cells: Sequence[SurfaceCells], eyes: Float[np.ndarray, "b 3"]) -> None:
        first = [i for i in range(len(cells)) if i == 0 or cells[i] is not cells[i - 1]]
        ends = [*first[1:], len(cells)]
        self._runs = [(cells[a], slice(a, b), cells[a].octants(eyes[a:b])) for a, b in zip(first, ends, strict=True)]
        self._beside = _BESIDE * np.array([item.step for item in cells])[:, None]

    def nearest(
        self, points: Float[np.ndarray, "b n 3"]
    ) -> tuple[Float[np.ndarray, "b n"], Float[np.ndarray, "b n 3"]]:
        """Return the signed distance (m) of points in the object frames, and its gradient there.

        Over a face the distance grows along its normal; beside all of them, away from the nearest sample.
        """
        offset, normal = np.empty(points.shape), np.empty(points.shape)
        for cells, rows, octants in self._runs:
            sample = cells.samples_near(points[rows], octants)
            offset[rows] = points[rows] - cells.surface.points[sample]
            normal[rows] = cells.surface.normals[cells.surface.faces[sample]]
        height, length = dot(offset, normal), np.sqrt(dot(offset, offset))
        above = length**2 - height**2 <= self._beside**2
        direction = np.where(above[..., None], normal, offset / np.maximum(length, 1e-9)[..., None])
        return np.where(above, height, length), direction
