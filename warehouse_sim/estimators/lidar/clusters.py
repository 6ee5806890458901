"""Clusters of a cloud, by a DBSCAN whose reach grows with the range, and which of them is the object."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from warehouse_sim.geometry.clouds import thin_by_voxels
from warehouse_sim.ranges import Range, ranged

_SPACINGS = 8.0
"""Neighbours are nearer than so many distances of neighbouring readings."""
_FEW = 150


@dataclass(frozen=True)
@ranged
class ClusterConfig:
    """What makes a cluster."""

    min_eps: Annotated[float, Range(1e-4, 100, "m")] = 0.1
    """Neighbours are at least this near (m), 0.0001-100 ..."""
    max_eps: Annotated[float, Range(1e-4, 100, "m")] = 0.25
    """... and at most this far (m), 0.0001-100."""
    min_points: Annotated[int, Range(1, 10_000)] = 10
    """A point with so many neighbours, itself included, is a core, 1-10,000."""
    min_points_few: Annotated[int, Range(1, 10_000)] = 5
    """The same in clouds of fewer than ``_FEW`` points, 1-10,000."""
    voxels: Annotated[float, Range(0, 10)] = 0.5
    """Points in a cube with this edge (in eps) are taken together, each counted, 0-10; 0 takes every one alone."""

    def __post_init__(self) -> None:
        if self.min_eps > self.max_eps:
            raise ValueError(f"min_eps {self.min_eps} m must not exceed max_eps {self.max_eps} m")


@dataclass(frozen=True, eq=False)
class Clusters:
    """What each of n points belongs to."""

    label: Int[np.ndarray, " n"]
    """Number of its cluster, -1 = noise."""
    is_core: Bool[np.ndarray, " n"]

    @property
    def count(self) -> int:
        """How many clusters there are."""
        return int(self.label.max(initial=-1)) + 1


def eps_at(z: Float[np.ndarray, " n"], spacing: float, config: ClusterConfig) -> Float[np.ndarray, " n"]:
    """Return the reach (m) at depths (m).

    Args:
        z: Metres along the optical axis.
        spacing: Angle between neighbouring readings (rad): 1 / f of a depth image, the step of a LiDAR's beams.
        config: Settings.
    """
    return np.clip(_SPACINGS * z * spacing, config.min_eps, config.max_eps)


def in_reaches(points: Float[np.ndarray, "n 3"], spacing: float, config: ClusterConfig) -> Float[np.ndarray, "n 3"]:
    """Return the points in coordinates in which the reach is 1 everywhere.

    (x, y) / eps(z) and the integral of dz / eps(z): where eps is proportional to z these are the ray's direction and
    log z, where it is constant the point itself, and where the two meet they are continuous.
    """
    z, rate = points[:, 2], _SPACINGS * spacing
    low, high = config.min_eps / rate, config.max_eps / rate
    ahead = np.minimum(z, low) / config.min_eps
    ahead += np.log(np.clip(z, low, high) / low) / rate
    ahead += np.maximum(z - high, 0.0) / config.max_eps
    eps = eps_at(z, spacing, config)[:, None]
    return np.hstack([points[:, :2] / eps, ahead[:, None]])


def cluster(points: Float[np.ndarray, "n 3"], spacing: float, config: ClusterConfig = ClusterConfig()) -> Clusters:
    """Return the clusters of a cloud by DBSCAN (Ester et al., KDD 1996).

    Args:
        points: Camera frame (m).
        spacing: Angle between neighbouring readings (rad).
        config: Settings.
    """
    if not len(points):
        return Clusters(np.zeros(0, np.int64), np.zeros(0, bool))
    scaled = in_reaches(np.asarray(points, dtype=float), spacing, config)
    centres, group = (scaled, np.arange(len(scaled))) if config.voxels == 0 else thin_by_voxels(scaled, config.voxels)
    weight = np.bincount(group, minlength=len(centres))
    least = config.min_points_few if len(points) < _FEW else config.min_points
    found = dbscan(centres, weight, least)
    return Clusters(found.label[group], found.is_core[group])


def dbscan(points: Float[np.ndarray, "n 3"], weight: Int[np.ndarray, " n"], least: int) -> Clusters:
    """Return the clusters of points whose reach is 1: cores within reach of each other, and what is in their reach.

    A point in reach of several clusters belongs to that of its nearest core.

    Args:
        points: In coordinates of any number.
        weight: How many points each stands for.
        least: Points in reach, itself included, that make a core.
    """
    pairs = cKDTree(points).query_pairs(1.0, output_type="ndarray")
    one, other = np.concatenate([pairs, pairs[:, ::-1]]).T
    is_core = weight + np.bincount(one, weight[other], len(points)) >= least
    label = np.full(len(points), -1, dtype=np.int64)
    cores = np.flatnonzero(is_core)
    if not len(cores):
        return Clusters(label, is_core)
    joined = is_core[pairs].all(axis=1)
    graph = coo_array((np.ones(joined.sum(), bool), tuple(pairs[joined].T)), shape=(len(points), len(points)))
    component = np.asarray(connected_components(graph, directed=False)[1])
    # Numbered as their first points come.
    _, first, number = np.unique(component[cores], return_index=True, return_inverse=True)
    label[cores] = np.argsort(np.argsort(first))[number]
    rest = np.flatnonzero(~is_core)
    found = cKDTree(points[cores]).query(points[rest], distance_upper_bound=np.nextafter(1.0, 2.0))
    distance, nearest = np.asarray(found[0]), np.asarray(found[1])
    reached = np.isfinite(distance)
    label[rest[reached]] = label[cores[nearest[reached]]]
    return Clusters(label, is_core)


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
        diameter: Of the object (m); None if unknown, then all points where there is no cluster.
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
