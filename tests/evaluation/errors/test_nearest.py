"""Mean nearest distances against scipy's brute force and its tree, on moves and clouds of every kind."""

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from tests.evaluation.pallet import nudge, random_motion, surface
from warehouse_sim.evaluation.errors import nearest
from warehouse_sim.evaluation.errors.nearest import mean_nearest_distance
from warehouse_sim.geometry.pose import transform_points


def moves(count: int, angle: float, offset: float) -> np.ndarray:
    rng = np.random.default_rng(2)
    return np.stack([random_motion(rng, angle, offset) for _ in range(count)])


def by_force(T: np.ndarray, points: np.ndarray) -> np.ndarray:
    return np.array([cdist(transform_points(move, points), points).min(axis=1).mean() for move in T])


def clustered() -> np.ndarray:
    """A coarse surface with a line of very many points, some twice, as printed cartons have."""
    line = np.column_stack([np.linspace(0, 0.01, 300), np.full(300, 0.4), np.zeros(300)])
    return np.concatenate([surface(), line, line[:40]])


@pytest.mark.parametrize(
    ("T", "points"),
    [
        (moves(60, 0.05, 0.05), surface()),
        (moves(20, 0.05, 0.05), clustered()),
        (moves(40, np.pi, 3.0), surface()),
        (np.concatenate([moves(20, 0.02, 0.02), moves(2, np.pi, 50.0)]), surface()),
        (np.tile(np.eye(4), (30, 1, 1)), surface()),
        (moves(40, 0.1, 0.1), surface() * [1.0, 1.0, 0.0]),
        (moves(40, 0.1, 0.1), np.array([[0.1, 0.2, 0.3]])),
        (np.stack([nudge(z=1.0)] * 20), surface()),
        # So far away that every point may be the nearest to something in each cube: none is prepared.
        (moves(40, 0.0, 2.0) @ nudge(z=300.0), np.random.default_rng(4).random((700, 3))),
    ],
)
def test_cubes_find_what_force_finds(monkeypatch, T, points):
    expected = by_force(T, points)
    assert mean_nearest_distance(T, points, KDTree(points)) == pytest.approx(expected, rel=1e-6, abs=1e-8)
    monkeypatch.setattr(nearest, "_FEW", 0)
    monkeypatch.setattr(nearest, "_MOST_ALONG", 20)
    for worth in (0, 4):  # 0: every cube of the block is prepared
        monkeypatch.setattr(nearest, "_WORTH", worth)
        assert mean_nearest_distance(T, points, KDTree(points)) == pytest.approx(expected, rel=1e-6, abs=1e-8)


def test_the_tree_is_hardly_requested_when_moves_are_alike(monkeypatch):
    T, points = moves(300, 0.005, 0.005), surface()
    monkeypatch.setattr(nearest, "_FEW", 0)
    evaluated = []
    distances = nearest._Candidates.distances

    def watch(self, T, points):
        evaluated.append((self.cubes[self.block.number(self.block.places(T, points)), 2] == 0).mean())
        return distances(self, T, points)

    monkeypatch.setattr(nearest._Candidates, "distances", watch)
    mean_nearest_distance(T, points, KDTree(points))
    assert np.mean(evaluated) < 0.2
