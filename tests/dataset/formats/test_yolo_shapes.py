"""Polygons, oriented boxes and key points of YOLO against slow and simple ways to the same."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from warehouse_sim.dataset.formats.yolo.polygons import mask_polygon
from warehouse_sim.dataset.formats.yolo.writer import key_points, mirrored, oriented_box, points_of
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.schema import Pocket

shapes = array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=24)
masks = arrays(bool, shapes, elements=st.booleans(), fill=st.booleans()).filter(np.any)


def filled(polygon: np.ndarray, shape: tuple[int, int], how) -> np.ndarray:
    """Fill as tools do: corners cut (Ultralytics) or rounded (supervision) to pixels."""
    image = np.zeros(shape, dtype=np.uint8)
    cv2.fillPoly(image, [how(polygon.astype(np.float32)).astype(np.int32)], 1)
    return image.astype(bool)


@given(masks)
def test_a_polygon_fills_its_mask_but_for_far_parts(mask: np.ndarray) -> None:
    polygon = mask_polygon(mask)
    assert len(polygon) >= 3
    cut, rounded = filled(polygon, mask.shape, np.trunc), filled(polygon, mask.shape, np.round)
    assert np.array_equal(cut, rounded)
    _, _, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    largest = stats[1:, cv2.CC_STAT_AREA].max()
    # Never worse than the largest part alone; exact where it is the only one.
    assert (cut ^ mask).sum() <= mask.sum() - largest


def test_a_frame_keeps_its_hole_and_two_parts_are_joined_where_they_are_nearest() -> None:
    frame = np.ones((20, 30), dtype=bool)
    frame[5:12, 8:20] = False
    assert np.array_equal(filled(mask_polygon(frame), frame.shape, np.trunc), frame)
    two = np.zeros((40, 60), dtype=bool)
    two[5:15, 5:20] = two[10:30, 26:50] = True
    assert (filled(mask_polygon(two), two.shape, np.trunc) & ~two).sum() == 6
    two[10:30, 26:50] = False
    two[10:12, 26:28] = True
    assert np.array_equal(filled(mask_polygon(two), two.shape, np.trunc)[:, :20], two[:, :20])
    assert not filled(mask_polygon(two), two.shape, np.trunc)[:, 20:].any()


@given(masks)
def test_an_oriented_box_holds_its_mask_lies_in_the_image_and_is_no_larger_than_the_upright_one(mask) -> None:
    corners, (height, width) = oriented_box(mask), mask.shape
    assert ((corners >= 0) & (corners <= [width, height])).all()
    sides = np.roll(corners, -1, axis=0) - corners
    np.testing.assert_allclose(sides[0] @ sides[1], 0.0, atol=1e-3 * (1 + np.abs(sides).max()))
    rows, columns = np.nonzero(mask)
    pixels = np.concatenate([np.stack([columns + dx, rows + dy], axis=1) for dx in (0, 1) for dy in (0, 1)])
    box = cv2.boundingRect(np.stack([columns, rows], axis=1).astype(np.int32))
    area = abs(np.cross(np.append(sides[0], 0), np.append(sides[1], 0))[2])
    assert area <= box[2] * box[3] + 1e-6
    for corner, side in zip(corners, sides, strict=True):
        inside = side[0] * (pixels - corner)[:, 1] - side[1] * (pixels - corner)[:, 0]
        assert inside.min() > -1e-3 * (1 + np.linalg.norm(side)) or inside.max() < 1e-3 * (1 + np.linalg.norm(side))


def test_a_turned_rectangle_away_from_the_border_has_its_own_box() -> None:
    image = np.zeros((200, 300), dtype=np.uint8)
    cv2.fillPoly(image, [cv2.boxPoints(((150, 100), (120, 40), 30.0)).astype(np.int32)], 1)
    corners = oriented_box(image.astype(bool))
    lengths = sorted(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1))
    np.testing.assert_allclose(lengths, [40, 40, 120, 120], atol=3.0)


# Two pockets on the sides -y and +y of a pallet of 1.2 x 0.8 m.
POCKETS = tuple(
    Pocket(face, make_transform(rotation_z(yaw), np.array([x, y, 0.0])), np.array([0.8, 0.3, 0.1]))
    for face, yaw, y in (("-y", np.pi / 2, -0.4), ("+y", -np.pi / 2, 0.4))
    for x in (-0.25, 0.25)
)
CAMERA = PinholeCamera(640, 480, 400.0, 400.0, 319.5, 239.5)
# The pallet's -y looks at a camera 3 m away: object x is image right, object z is image up.
FACING = make_transform(np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]), np.array([0.0, 0.2, 3.0]))
CLEAR = np.zeros((480, 640), dtype=np.float32)


def test_corners_come_from_left_to_right_and_are_projected() -> None:
    assert points_of(POCKETS) == 8
    found = key_points(POCKETS, FACING, CAMERA, CLEAR, 8)
    assert (found[:, 2] == 2).all()
    x = np.array([-0.4, -0.1, -0.1, -0.4, 0.1, 0.4, 0.4, 0.1])
    y = 0.2 + np.array([-0.05, -0.05, 0.05, 0.05] * 2)
    expected = np.stack([400 * x / 2.6 + 319.5, 400 * y / 2.6 + 239.5], axis=1)
    np.testing.assert_allclose(found[:, :2], expected, atol=1e-9)


def test_half_a_turn_of_the_pallet_changes_no_point() -> None:
    turned = FACING @ make_transform(rotation_z(np.pi), np.zeros(3))
    first, second = (key_points(POCKETS, T, CAMERA, CLEAR, 8) for T in (FACING, turned))
    np.testing.assert_allclose(first, second, atol=1e-9)


def test_the_mirror_image_has_the_mirrored_points() -> None:
    away = np.array([0.4, 0.2, 3.0])
    left, right = (
        make_transform(FACING[:3, :3] @ rotation_z(yaw), away * [side, 1, 1]) for yaw, side in ((0.3, 1), (-0.3, -1))
    )
    seen, other = (key_points(POCKETS, T, CAMERA, CLEAR, 8) for T in (left, right))
    assert mirrored(8) == [5, 4, 7, 6, 1, 0, 3, 2]
    flipped = np.stack([639 - seen[:, 0], seen[:, 1], seen[:, 2]], axis=1)[mirrored(8)]
    np.testing.assert_allclose(flipped, other, atol=1e-9)


def test_flags_tell_hidden_points_from_those_outside() -> None:
    depth = np.full((480, 640), 5.0, dtype=np.float32)
    depth[:, :300] = 2.0
    found = key_points(POCKETS, FACING, CAMERA, depth, 8)
    assert set(found[:, 2]) == {1, 2}
    assert [flag for u, _, flag in found] == [1 if round(u) < 300 else 2 for u, _, flag in found]
    aside = FACING.copy()
    aside[0, 3] = 2.1
    assert (key_points(POCKETS, aside, CAMERA, CLEAR, 8)[4:] == 0).all()
    behind = FACING.copy()
    behind[2, 3] = -3.0
    assert not key_points(POCKETS, behind, CAMERA, CLEAR, 8).any()


def test_from_above_no_side_faces_the_camera_and_places_stay_empty() -> None:
    above = make_transform(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 3.0]))
    assert not key_points(POCKETS, above, CAMERA, CLEAR, 8).any()
    assert not key_points((), FACING, CAMERA, CLEAR, 8).any()
    assert points_of(()) == 0


@pytest.mark.parametrize("count", [4, 8, 12])
def test_the_mirror_undoes_itself(count: int) -> None:
    assert [mirrored(count)[index] for index in mirrored(count)] == list(range(count))
