"""Boxes in images and in space."""

import numpy as np

from warehouse_sim.geometry.boxes import (
    OrientedBox,
    box_corners,
    box_coverage,
    box_edges,
    box_ious,
    mask_box_xyxy,
    mask_intersections,
)
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
