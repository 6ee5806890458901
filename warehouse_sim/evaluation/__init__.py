"""Scores: predictions in a file against the ground truth of a dataset folder, and a page to look at.

Nothing here needs a network library, a renderer or a simulator.
"""

from warehouse_sim.evaluation.scores import Scores, read_scores, write_scores
from warehouse_sim.evaluation.scoring import evaluate

__all__ = ["Scores", "evaluate", "read_scores", "write_scores"]
