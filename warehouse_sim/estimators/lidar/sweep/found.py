"""What is found in a sweep: a box of its range image, and of the points in it those of the object."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.estimators.image import Detection
from warehouse_sim.estimators.lidar.clusters import ClusterConfig, chosen_points, cluster
from warehouse_sim.estimators.lidar.sweep.floor import Plane, above_floor
from warehouse_sim.estimators.lidar.sweep.range_image import Box, SweepGrid, in_box
from warehouse_sim.estimators.lidar.sweep.view import facing_points
from warehouse_sim.estimators.segmenters.cluster import BoxClusterConfig
from warehouse_sim.geometry.pose import Transform, invert, transform_points

_LEAST_LIKELY = 8
"""Points of a box that must show an object, that the others are left out."""


@dataclass(frozen=True)
class OwnPointsConfig(BoxClusterConfig):
    """How an object's points are found in its box."""

    likely_clusters: ClusterConfig = field(
        default_factory=lambda: ClusterConfig(least_eps=0.2, most_eps=0.4, min_points=5, min_points_few=3)
    )
    """What makes a cluster of points that a network names: they are few, and mostly right."""


@dataclass(frozen=True, eq=False)
class SweepDetection(Detection):
    """A detection that a sweep was looked at for."""

    own: Bool[np.ndarray, " n"] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    """Which points of the sweep are the object's."""


@dataclass(frozen=True, eq=False)
class FoundInSweep:
    """One object that was found in a sweep."""

    box: Box
    """Left, top, right, bottom of edges of the range image (px)."""
    score: float
    """Trust in it, 0-1."""
    class_name: str
    """Its class; empty where ``model`` says more."""
    model: str | None = None
    """Name of its geometry, where the detector tells geometries apart."""
    likely: Bool[np.ndarray, " n"] | None = None
    """Which points of the sweep show an object of any kind; None where nobody says."""


def facing(grid: SweepGrid, box: Box, up: Float[np.ndarray, " 3"]) -> Transform:
    """Return T_lidar_view of the level frame (x right, y down, z ahead) that looks at a box; see ``facing_points``."""
    middle = [(box[0] + box[2]) / 2.0, (box[1] + box[3]) / 2.0]
    return facing_points(grid.directions(np.array([middle])), up)


def own_points(
    points: Float[np.ndarray, "n 3"],
    grid: SweepGrid,
    box: Box,
    T_lidar_view: Transform,
    floor: Plane | None,
    likely: Bool[np.ndarray, " n"] | None = None,
    config: OwnPointsConfig = OwnPointsConfig(),
) -> Bool[np.ndarray, " n"]:
    """Return which points of a sweep are the object's in a box: a dense near cluster of what is likely its own.

    Where nothing is known to be likely, that is what lies above the floor.

    Args:
        points: LiDAR frame (m).
        grid: Of the box.
        box: Where it is.
        T_lidar_view: The frame that looks at it, along which clusters reach farther with the distance.
        floor: Plane of the floor; None where it is unknown, and all points may be the object's.
        likely: Which points show an object, as far as a detector can tell; where it names next to none in the box,
            nothing is made of it. None where nobody says.
        config: How clusters are found.
    """
    inside = np.flatnonzero(in_box(grid, points, box))
    clusters = config.clusters
    if likely is not None and likely[inside].sum() >= _LEAST_LIKELY:
        # The network knows the floor better than a height does: lower boards lie on it.
        inside, clusters = inside[likely[inside]], config.likely_clusters
    elif floor is not None:
        least = config.floor + config.floor_fraction * np.linalg.norm(points[inside], axis=1)
        inside = inside[above_floor(points[inside], floor) > least]
    own = np.zeros(len(points), dtype=bool)
    if len(inside):
        seen = transform_points(invert(T_lidar_view), points[inside])
        area = (box[2] - box[0]) / grid.columns_per_rad * (box[3] - box[1]) / grid.rows_per_rad
        spacing = float(np.sqrt(area / len(inside)))
        own[inside] = chosen_points(seen, cluster(seen, spacing, clusters))
    return own
