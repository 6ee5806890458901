"""The points of an object on which pose errors are measured."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial import KDTree

from warehouse_sim.dataset.object_gt import hull_corners
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import TargetRecord
from warehouse_sim.geometry.boxes import box_corners


@dataclass(frozen=True, eq=False)
class ErrorPoints:
    """Where the errors of one object are measured, in the object frame."""

    surface: Float[np.ndarray, "m 3"]
    """Points spread evenly over the surface (m), for means."""
    hull: Float[np.ndarray, "h 3"]
    """The corners of their convex hull (m), for maxima: far fewer, and the same maxima."""
    tree: KDTree
    """Nearest-neighbour search among ``surface``."""


def error_points(points: Float[np.ndarray, "m 3"]) -> ErrorPoints:
    """Prepare an object for its errors.

    Args:
        points: Of its model (m, object frame): the vertices of BOP's ``models_eval``, evenly meshed, as they are for
            every scorer of the BOP family, so that the numbers compare; of what has no CAD, its cloud.
    """
    return ErrorPoints(points, hull_corners(points), KDTree(points))


class ErrorModels:
    """What errors of targets are measured on: the model of their obj_id, or their own where there is no CAD.

    Args:
        objects: Geometry by object id.
        least_points: Targets whose own model has fewer points cannot be judged.
    """

    def __init__(self, objects: Mapping[int, ObjectInfo], least_points: int) -> None:
        self._objects, self._least = objects, max(least_points, 1)
        self._points: dict[int, ErrorPoints] = {}

    def info(self, target: TargetRecord) -> ObjectInfo:
        """Return the geometry of a target."""
        return target.info(self._objects)

    def counts(self, target: TargetRecord) -> bool:
        """Return whether a target's model has points enough."""
        info = self.info(target)
        return info.has_cad or len(info.model_points()) >= self._least

    def points(self, target: TargetRecord) -> ErrorPoints:
        """Return where the errors of a target are measured; the corners of its box where its cloud is empty."""
        info = self.info(target)
        if not info.has_cad:
            # Not kept: of a large dataset, clouds would fill the memory.
            cloud = info.model_points()
            return error_points(cloud if len(cloud) else box_corners(info.size))
        if info.obj_id not in self._points:
            self._points[info.obj_id] = error_points(info.model_points())
        return self._points[info.obj_id]
