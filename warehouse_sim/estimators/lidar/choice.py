"""Which cluster of a box is the object: a dense one, and of the dense ones the nearest."""

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.lidar.clusters import Clusters

_DENSE = 0.5
"""Clusters with at least this fraction of the cores of the largest are dense."""


def chosen_points(
    points: Float[np.ndarray, "n 3"], clusters: Clusters, diameter: float | None = None
) -> Bool[np.ndarray, " n"]:
    """Return which points are the object's.

    Coimbra (2023) takes the cluster with the highest density that is closest, without a formula; here those with half
    the cores of the largest are dense, and the one with the least median range is chosen, of equal ones the larger.
    Where there is no cluster, points within half a diameter of the median depth are the object's.

    Args:
        points: Of a box (camera frame, m).
        clusters: Of these points.
        diameter: Of the object (m); None where nobody knows, then all points where there is no cluster.
    """
    if not len(points):
        return np.zeros(0, bool)
    if clusters.count == 0:
        depth = points[:, 2]
        return np.ones(len(points), bool) if diameter is None else np.abs(depth - np.median(depth)) <= diameter / 2.0
    cores = np.bincount(clusters.label[clusters.is_core], minlength=clusters.count)
    distance = np.linalg.norm(points, axis=1)
    dense = np.flatnonzero(cores >= _DENSE * cores.max())
    nearest = min(dense, key=lambda number: (float(np.median(distance[clusters.label == number])), -cores[number]))
    return np.asarray(clusters.label == nearest)
