"""From detections to poses in files: select points, propose, choose, refine."""

from warehouse_sim.learning.methods import ESTIMATORS

__all__ = ["ESTIMATORS"]
