"""Boxes in images and in space."""

import numpy as np
import pytest

from warehouse_sim.geometry import mesh as module
from warehouse_sim.geometry.boxes import (
    OrientedBox,
    box_corners,
    box_coverage,
    box_edges,
    box_ious,
    mask_box_xyxy,
    mask_intersections,
)
from warehouse_sim.geometry.convex import area, convex_hull, grown
from warehouse_sim.geometry.mesh import equal_rows
from warehouse_sim.geometry.pose import make_transform, rotation_z


def test_box_edges_join_corners_that_differ_in_one_coordinate() -> None:
    corners = box_corners(np.array([1.0, 2.0, 3.0]))
    lengths = [np.linalg.norm(corners[a] - corners[b]) for a, b in box_edges()]
    assert sorted(np.round(lengths, 12)) == [1.0] * 4 + [2.0] * 4 + [3.0] * 4


def test_oriented_box_corners_are_in_the_parent_frame() -> None:
    box = OrientedBox(make_transform(rotation_z(np.pi / 2), np.array([10.0, 0, 0])), np.array([2.0, 4.0, 6.0]))
    corners = box.corners()
    np.testing.assert_allclose(corners.min(0), [8, -1, -3])
    np.testing.assert_allclose(corners.max(0), [12, 1, 3])


def test_mask_box_is_inclusive_and_none_when_empty() -> None:
    mask = np.zeros((6, 9), dtype=bool)
    assert mask_box_xyxy(mask) is None
    mask[2:4, 3:8] = True
    assert mask_box_xyxy(mask) == (3, 2, 7, 3)


def counted(box: np.ndarray, side: int = 40) -> np.ndarray:
    """Return the pixels of a box of whole edges."""
    mask = np.zeros((side, side), dtype=bool)
    left, top, right, bottom = box.astype(int)
    mask[top:bottom, left:right] = True
    return mask


def test_overlaps_of_boxes_are_those_of_their_pixels() -> None:
    rng = np.random.default_rng(0)
    low = rng.integers(0, 20, (12, 2))
    boxes = np.concatenate([low, low + rng.integers(1, 20, (12, 2))], axis=1).astype(float)
    masks = np.stack([counted(box) for box in boxes])
    shared = (masks[:, None] & masks).sum(axis=(2, 3))
    union = (masks[:, None] | masks).sum(axis=(2, 3))
    np.testing.assert_allclose(box_ious(boxes, boxes), shared / union)
    np.testing.assert_array_equal(mask_intersections(masks, masks), shared)
    np.testing.assert_allclose(box_coverage(boxes, boxes), shared / masks.sum(axis=(1, 2))[:, None])


def test_where_there_is_no_mask_nothing_is_shared() -> None:
    masks, none = np.ones((2, 3, 4), dtype=bool), np.zeros((0, 3, 4), dtype=bool)
    assert mask_intersections(masks, none).shape == (2, 0)
    assert mask_intersections(none, masks).shape == (0, 2)


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


@pytest.mark.parametrize("collide", [False, True], ids=["hashed", "all hashes equal"])
@pytest.mark.parametrize("count", [0, 1, 2, 5000])
def test_rows_are_grouped_as_numpy_groups_them(count: int, collide: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if collide:
        monkeypatch.setattr(module, "_FACTORS", np.zeros(64, np.uint64))
    rows = np.random.default_rng(count).integers(-3, 4, (count, 3)).astype(float)
    one, group = equal_rows(rows)
    assert (rows[one][group] == rows).all()
    assert len(one) == len(np.unique(rows, axis=0))
    assert sorted(group[one]) == list(range(len(one)))


def test_rows_that_differ_in_one_bit_are_told_apart() -> None:
    rows = np.zeros((1 + 96, 12), np.uint8)
    for bit in range(96):
        rows[1 + bit, bit // 8] = 1 << bit % 8
    assert len(equal_rows(rows)[0]) == len(rows)
