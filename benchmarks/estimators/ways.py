"""How the tables here use an estimator; the words are those of ``warehouse_sim.benchmark.entrants.ways``."""

from collections.abc import Mapping

from warehouse_sim.benchmark.entrants.ways import Way, way_of
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators.api import PoseEstimator

__all__ = ["Way", "open_way", "way_of"]


def open_way(method: str, objects: Mapping[int, ObjectInfo], uncertainty: bool = True) -> PoseEstimator:
    """Return the estimator, shown the objects of a dataset where it learns them that way."""
    return way_of(method).open(objects, uncertainty)
