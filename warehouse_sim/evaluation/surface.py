"""The points of an object on which pose errors are measured."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial import KDTree

from warehouse_sim.dataset.object_truth import hull_corners
from warehouse_sim.geometry.mesh import TriangleMesh


@dataclass(frozen=True, eq=False)
class ErrorPoints:
    """Where the errors of one object are measured, in the object frame."""

    surface: Float[np.ndarray, "m 3"]
    """Points spread evenly over the surface (m), for means."""
    hull: Float[np.ndarray, "h 3"]
    """The corners of their convex hull (m), for maxima: far fewer, and the same maxima."""
    tree: KDTree
    """Nearest-neighbour search among ``surface``."""


def error_points(mesh: TriangleMesh) -> ErrorPoints:
    """Prepare an object for its errors.

    Args:
        mesh: The object's evenly meshed surface (m), BOP's ``models_eval``: its vertices are the points, as they are
            for every scorer of the BOP family, so that the numbers compare.
    """
    points = mesh.vertices
    return ErrorPoints(points, hull_corners(points), KDTree(points))
