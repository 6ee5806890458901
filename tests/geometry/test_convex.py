import numpy as np
import pytest

from warehouse_sim.geometry.convex import area, convex_hull, grown


def test_the_hull_of_a_square_with_inner_and_border_points_is_its_four_corners() -> None:
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    inner = np.random.default_rng(0).random((50, 2)) * 2.0
    hull = convex_hull(np.concatenate([inner, corners, [[1.0, 0.0], [2.0, 0.5]]]))
    assert {tuple(row) for row in hull} == {tuple(row) for row in corners}
    assert area(hull) == pytest.approx(4.0)


def test_every_point_is_left_of_every_edge() -> None:
    for seed in range(20):
        points = np.random.default_rng(seed).normal(size=(40, 2))
        hull = convex_hull(points)
        edges = np.roll(hull, -1, axis=0) - hull
        to_points = points[None] - hull[:, None]
        assert (edges[:, :1] * to_points[..., 1] - edges[:, 1:] * to_points[..., 0]).min() > -1e-8, seed


def test_growing_moves_every_edge_out_by_the_distance() -> None:
    for seed in range(20):
        hull = convex_hull(np.random.default_rng(seed).normal(size=(12, 2)))
        bigger = grown(hull, 0.25)
        along = np.roll(hull, -1, axis=0) - hull
        out = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True)
        np.testing.assert_allclose(((bigger - hull) * out).sum(axis=1), 0.25, err_msg=str(seed))
        np.testing.assert_allclose(((np.roll(bigger, -1, axis=0) - hull) * out).sum(axis=1), 0.25, err_msg=str(seed))
