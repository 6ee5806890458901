"""Nearest points on the surfaces that face a camera, for a whole batch of objects in one query."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import cKDTree

from warehouse_sim.estimators.pose.icp.surface import CadSurface
from warehouse_sim.estimators.pose.icp.triangles import closest_points, dot

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
        self.corners = np.concatenate(corners)
        """Corners of every triangle in the anisotropic space."""
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
        offset = np.repeat(scaled.reshape(-1, 3), _CANDIDATES, axis=0)
        offset -= closest_points(offset, self.corners[faces])
        rows = _CANDIDATES * np.arange(batch * count)
        best = dot(offset, offset).reshape(-1, _CANDIDATES).argmin(axis=1) + rows
        offset, normal = offset[best], self._normals[faces[best]]
        distance, height = np.sqrt(dot(offset, offset)), dot(offset, normal)
        above = np.abs(height) >= 0.999 * distance
        direction = np.where(above[:, None], normal, offset / np.maximum(distance, 1e-9)[:, None])
        return np.where(above, height, distance).reshape(batch, count), direction.reshape(points.shape) @ self._metric
