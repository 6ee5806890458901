"""As many points as asked, and how well they cover: against scikit-learn's K-means and the definition of farthest."""

import numpy as np
import pytest
from sklearn.cluster import KMeans

from warehouse_sim.estimators.lidar.pointcloud import farthest_points, fill_up, kmeans_centres, resample


def cloud(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform([0, 0, 3], [1.2, 0.144, 3.8], (count, 3))


@pytest.mark.parametrize("method", ["kmeans", "farthest", "random"])
@pytest.mark.parametrize("present", [1, 3, 499, 500, 501, 4000, 20_000])
def test_exactly_as_many_as_requested(method: str, present: int) -> None:
    points = cloud(present)
    found = resample(points, 500, method, np.random.default_rng(1))
    assert found.shape == (500, 3)
    assert np.isfinite(found).all()
    assert len(np.unique(found, axis=0)) == min(present, 500)
    assert (found.min(axis=0) >= points.min(axis=0) - 1e-12).all()
    assert (found.max(axis=0) <= points.max(axis=0) + 1e-12).all()
    again = resample(points, 500, method, np.random.default_rng(1))
    np.testing.assert_array_equal(found, again)


@pytest.mark.parametrize("method", ["kmeans", "farthest", "random"])
def test_many_points_at_one_place_are_no_matter(method: str) -> None:
    points = np.concatenate([np.zeros((3000, 3)), cloud(40)])
    found = resample(points, 100, method, np.random.default_rng(0))
    assert found.shape == (100, 3)
    assert np.isfinite(found).all()
    if method == "farthest":
        assert len(np.unique(found, axis=0)) >= 40


def test_few_points_are_all_kept_and_no_points_are_rejected() -> None:
    index = fill_up(30, 100, np.random.default_rng(0))
    assert sorted(set(index.tolist())) == list(range(30))
    assert len(index) == 100
    with pytest.raises(ValueError, match="without points"):
        resample(np.zeros((0, 3)), 10, "kmeans", np.random.default_rng(0))


def test_the_centres_are_as_good_as_those_of_scikit_learn() -> None:
    points, rng = cloud(2000), np.random.default_rng(3)
    found = kmeans_centres(points, 256, rng)
    start = points[np.random.default_rng(3).permutation(len(points))[:256]]
    theirs = KMeans(256, init=start, n_init=1, max_iter=10).fit(points).inertia_
    ours = (np.linalg.norm(points[:, None] - found[None], axis=2).min(axis=1) ** 2).sum()
    assert ours < 1.03 * theirs
    random = (np.linalg.norm(points[:, None] - start[None], axis=2).min(axis=1) ** 2).sum()
    assert ours < 0.8 * random


def test_each_is_farthest_from_those_before() -> None:
    points = cloud(700)
    taken = farthest_points(points, 60, np.random.default_rng(5))
    assert len(set(taken.tolist())) == 60
    for step in range(1, 60):
        nearest = np.linalg.norm(points[:, None] - points[taken[:step]][None], axis=2).min(axis=1)
        assert nearest[taken[step]] > nearest.max() - 1e-5
