import numpy as np

from warehouse_sim.geometry.boxes import OrientedBox, box_corners, box_edges, mask_box_xyxy
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
