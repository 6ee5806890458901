import numpy as np

from warehouse_sim.geometry.boxes import box_coverage, box_ious, mask_intersections


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
