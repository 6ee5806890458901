"""DBSCAN with a reach that grows with range against its definition, and which cluster is chosen."""

import numpy as np
import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.lidar.clusters import (
    ClusterConfig,
    Clusters,
    chosen_points,
    cluster,
    eps_at,
    in_reaches,
)

SPACING = 1.0 / 700.0
PLAIN = ClusterConfig(voxels=0.0)


def blob(centre: tuple[float, float, float], size: float, count: int, seed: int) -> np.ndarray:
    return np.asarray(centre) + np.random.default_rng(seed).uniform(-size / 2, size / 2, (count, 3))


def by_definition(points: np.ndarray, least: int) -> tuple[np.ndarray, np.ndarray]:
    """Return cores and the cluster of each core, by growing clusters from neighbour to neighbour."""
    near = np.linalg.norm(points[:, None] - points[None], axis=2) <= 1.0
    core, label = near.sum(axis=1) >= least, np.full(len(points), -1)
    for start in np.flatnonzero(core):
        if label[start] >= 0:
            continue
        waiting, number = [start], label.max() + 1
        while waiting:
            one = waiting.pop()
            if core[one] and label[one] < 0:
                label[one] = number
                waiting += np.flatnonzero(near[one] & core & (label < 0)).tolist()
    return core, label


def test_it_is_dbscan() -> None:
    points = np.concatenate([
        blob((0, 0, 4), 0.3, 150, 0), blob((0.6, 0, 4.2), 0.4, 120, 1), blob((0, 0, 30), 20.0, 60, 2)
    ])  # fmt: skip
    found = cluster(points, 0.01, PLAIN)
    core, label = by_definition(in_reaches(points, 0.01, PLAIN), 10)
    np.testing.assert_array_equal(found.is_core, core)
    assert found.count == label.max() + 1 >= 2
    for number in range(found.count):
        assert len(set(label[core & (found.label == number)])) == 1
    # Border points belong to a core in reach; all others are noise.
    scaled = in_reaches(points, 0.01, PLAIN)
    for one in np.flatnonzero(~core):
        near = core & (np.linalg.norm(scaled - scaled[one], axis=1) <= 1.0)
        assert (found.label[one] in set(found.label[near])) if near.any() else found.label[one] == -1


def test_the_reach_is_one_everywhere() -> None:
    """Small distances in the new coordinates are metric ones over eps, before, between and behind the limits."""
    rng, config = np.random.default_rng(0), ClusterConfig()
    for spacing in (SPACING, 0.007):
        z = rng.uniform(0.5, 60, 2000)
        points = np.stack([rng.uniform(-0.05, 0.05, 2000) * z, rng.uniform(-0.05, 0.05, 2000) * z, z], axis=1)
        step = rng.standard_normal((2000, 3)) * 1e-5
        moved = np.linalg.norm(in_reaches(points + step, spacing, config) - in_reaches(points, spacing, config), axis=1)
        expected = np.linalg.norm(step, axis=1) / eps_at(z, spacing, config)
        # Off the axis the coordinates are turned a little against each other.
        np.testing.assert_allclose(moved, expected, rtol=0.06)


def test_points_taken_together_give_the_same_clusters() -> None:
    thin = np.array([1.0, 1.0, 0.02])
    points = np.concatenate([
        blob((0, 0, 0), 0.5, 3000, 0) * thin + [0, 0, 5],
        blob((0, 0, 0), 0.5, 2500, 1) * thin + [0.9, 0, 5],
        blob((0, 0, 0), 0.6, 2000, 2) * thin + [0, 0, 8],
    ])  # fmt: skip
    assert {cluster(points, SPACING).count, cluster(points, SPACING, PLAIN).count} == {3}
    together, alone = cluster(points, SPACING).label, cluster(points, SPACING, PLAIN).label
    both = (together >= 0) & (alone >= 0)
    assert both.mean() > 0.97
    assert len(set(zip(together[both].tolist(), alone[both].tolist(), strict=True))) == 3


def test_no_points_no_clusters_and_limits_that_contradict() -> None:
    assert cluster(np.zeros((0, 3)), SPACING).count == 0
    with pytest.raises(ConfigError, match=r"min_eps 0.5 m must not exceed max_eps 0.25 m"):
        ClusterConfig(min_eps=0.5)


def labelled(*counts: tuple[int, int]) -> Clusters:
    """Clusters of so many cores and so many others each."""
    label = np.concatenate([np.full(core + rest, number) for number, (core, rest) in enumerate(counts)])
    core = np.concatenate([np.arange(cores + rest) < cores for cores, rest in counts])
    return Clusters(label, core)


def test_of_dense_clusters_the_nearest_is_chosen() -> None:
    clusters = labelled((100, 20), (60, 5), (10, 80))
    points = np.zeros((len(clusters.label), 3))
    points[:, 2] = np.array([6.0, 4.0, 2.0])[clusters.label]
    assert (chosen_points(points, clusters) == (clusters.label == 1)).all()
    points[:, 2] = np.array([3.0, 4.0, 2.0])[clusters.label]
    assert (chosen_points(points, clusters) == (clusters.label == 0)).all()
    # Of equal ones the larger.
    points[:, 2] = 4.0
    assert (chosen_points(points, clusters) == (clusters.label == 0)).all()


def test_without_a_cluster_the_median_depth_decides() -> None:
    points = np.column_stack([np.zeros((5, 2)), [4.0, 4.1, 4.2, 9.0, 1.0]])
    nothing = Clusters(np.full(5, -1), np.zeros(5, bool))
    np.testing.assert_array_equal(chosen_points(points, nothing, 1.4), [True, True, True, False, False])
    assert chosen_points(points, nothing).all()
    assert len(chosen_points(np.zeros((0, 3)), Clusters(np.zeros(0, int), np.zeros(0, bool)))) == 0
