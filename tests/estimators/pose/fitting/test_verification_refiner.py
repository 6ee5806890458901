"""A network that is wrong is put right by the image, one that is right stays, and what has no image is left alone."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.estimators.pose.fitting.test_fit import CAMERA, HALF_TURN, SIZE, box, seen
from warehouse_sim.estimators.pose.choose import Candidates
from warehouse_sim.estimators.pose.fitting.hypotheses import masked_points
from warehouse_sim.estimators.pose.fitting.refiners import VerificationRefiner
from warehouse_sim.estimators.pose.fitting.search import FitConfig
from warehouse_sim.estimators.pose.fitting.verification import DepthView
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import (
    make_transform,
    quat_wxyz_from_matrix,
    rotation_angle,
    rotation_z,
    transform_points,
)


def all_of(row, points):
    return np.ones(len(points), dtype=bool)


def refined(T_wrong: np.ndarray, gravity: bool = True, view: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """Return the refined pose and the true one, of a network that proposes ``T_wrong`` in the object's frame."""
    image, gt = seen(make_transform(rotation_z(0.6), np.array([3.0, 0.2, 0.15])), -0.2)
    mask = image.detections[0].pixels(CAMERA.height, CAMERA.width)
    points = masked_points(image, mask, np.random.default_rng(0))
    looked_at = DepthView(CAMERA, image.depth, mask, points, image.gravity if gravity else None)
    item = SimpleNamespace(position=0, obj_id=3, points=points, view=looked_at if view else None, bonus=0.0)
    T = gt @ T_wrong
    quat = quat_wxyz_from_matrix(T[:3, :3])[None, None]
    proposals = SimpleNamespace(candidates=Candidates(quat, T[None, None, :3, 3], np.ones((1, 1))), trusted=all_of)
    refiner = VerificationRefiner({3: box().mesh()}, {3: HALF_TURN}, FitConfig(), 0)
    return refiner(T[None], [item], proposals)[0], gt


def errors(found: np.ndarray, gt: np.ndarray) -> tuple[float, float]:
    looks = gt @ HALF_TURN.transforms
    turns = rotation_angle(looks[:, :3, :3], found[None, :3, :3])
    return float(np.linalg.norm(found[:3, 3] - gt[:3, 3])), float(np.degrees(turns.min()))


@pytest.mark.parametrize(
    "wrong",
    [
        np.eye(4),
        make_transform(rotation_z(np.pi / 2), np.zeros(3)),
        make_transform(rotation_z(0.4), np.array([0.3, -0.2, 0.1])),
    ],
    ids=["right", "quarter turn", "far off"],
)
def test_the_image_finds_the_object_whatever_the_network_says(wrong: np.ndarray) -> None:
    shift, turn = errors(*refined(wrong))
    assert shift < 0.01
    assert turn < 0.5


def test_without_gravity_the_points_alone_level_it() -> None:
    shift, turn = errors(*refined(make_transform(rotation_z(0.1), np.array([0.05, 0.0, 0.0])), gravity=False))
    assert shift < 0.02
    assert turn < 1.5


def test_what_has_no_image_stays_as_it_is() -> None:
    wrong = make_transform(rotation_z(0.4), np.zeros(3))
    found, gt = refined(wrong, view=False)
    np.testing.assert_array_equal(found, gt @ wrong)


def test_what_the_network_trusts_is_fitted_where_the_mask_is_a_box() -> None:
    """Floor, wall and object are in the box; the object has one point of twelve."""
    image, gt = seen(make_transform(rotation_z(0.6), np.array([3.0, 0.2, 0.15])), -0.2)
    mask = image.depth > 0
    points = masked_points(image, mask, np.random.default_rng(0))
    view = DepthView(CAMERA, image.depth, mask, points, image.gravity)
    item = SimpleNamespace(position=0, obj_id=3, points=points, view=view, bonus=0.0)
    low, high = box().mesh().vertices.min(axis=0) - 0.005, box().mesh().vertices.max(axis=0) + 0.005
    inside = transform_points(np.linalg.inv(gt), points)
    own = ((inside >= low) & (inside <= high)).all(axis=1)
    assert own.sum() < 0.1 * len(own)
    wrong = gt @ make_transform(rotation_z(0.5), np.array([0.2, -0.1, 0.0]))
    quat = quat_wxyz_from_matrix(wrong[:3, :3])[None, None]
    candidates = Candidates(quat, wrong[None, None, :3, 3], np.ones((1, 1)))
    refiner = VerificationRefiner({3: box().mesh()}, {3: HALF_TURN}, FitConfig(), 0)
    found = {
        name: errors(refiner(wrong[None], [item], SimpleNamespace(candidates=candidates, trusted=trusted))[0], gt)
        for name, trusted in (("own", lambda row, given: own), ("all", lambda row, given: np.ones(len(given), bool)))
    }
    assert found["own"][0] < 0.01
    assert found["own"][1] < 0.5
    assert found["all"][0] > 0.5  # without, the floor wins


def test_the_image_says_which_object_a_detection_is() -> None:
    """A smaller crate leaves points unexplained; where a larger one should be, the camera looks through."""
    image, gt = seen(make_transform(rotation_z(0.6), np.array([3.0, 0.2, 0.15])), -0.2)
    mask = image.detections[0].pixels(CAMERA.height, CAMERA.width)
    points = masked_points(image, mask, np.random.default_rng(0))
    view = DepthView(CAMERA, image.depth, mask, points, image.gravity)
    sizes = {2: SIZE * [0.8, 0.9, 1.0], 3: SIZE, 4: SIZE * [1.15, 1.2, 1.0]}
    meshes = {number: TriangleMesh(box_corners(size), unit_box().faces) for number, size in sizes.items()}
    items = [SimpleNamespace(position=0, obj_id=number, points=points, view=view, bonus=0.0) for number in sizes]
    quat = np.tile(quat_wxyz_from_matrix(gt[:3, :3]), (3, 1, 1))
    # The network is surest of a wrong one.
    candidates = Candidates(quat, np.tile(gt[:3, 3], (3, 1, 1)), np.array([[0.99], [0.2], [0.5]]))
    refiner = VerificationRefiner(meshes, dict.fromkeys(sizes, HALF_TURN), FitConfig(), 0)
    T = refiner(np.stack([gt] * 3), items, SimpleNamespace(candidates=candidates, trusted=all_of))
    worth = refiner.prefer(T, items, SimpleNamespace(candidates=candidates, trusted=all_of))
    assert worth.argmax() == 1
    assert worth[2] < worth[1] - 0.2


def test_without_an_image_the_network_says_which_object_it_is() -> None:
    items = [SimpleNamespace(position=0, obj_id=3, points=np.zeros((1, 3)), view=None, bonus=0.0)] * 2
    candidates = Candidates(np.tile([1.0, 0, 0, 0], (2, 3, 1)), np.zeros((2, 3, 3)), np.array([[0.1, 0.3, 0.2]] * 2))
    refiner = VerificationRefiner({3: box().mesh()}, {3: HALF_TURN}, FitConfig(), 0)
    worth = refiner.prefer(np.stack([np.eye(4)] * 2), items, SimpleNamespace(candidates=candidates, trusted=all_of))
    np.testing.assert_array_equal(worth, [0.3, 0.3])


def test_the_network_decides_how_a_crate_lies_of_which_little_more_than_a_gap_shows() -> None:
    """Of a long side behind a board with a gap, a crate turned by a quarter shows a larger part: that says nothing."""
    image, gt = seen(make_transform(rotation_z(np.pi / 2), np.array([3.0, 0.0, 1.1])), 0.0)
    gap = np.abs(np.arange(CAMERA.width) - CAMERA.cx) < 12.0
    depth = np.where(gap, image.depth, np.float32(1.5))
    mask = image.detections[0].pixels(CAMERA.height, CAMERA.width) & gap
    points = masked_points(replace(image, depth=depth), mask, np.random.default_rng(0))
    looked_at = DepthView(CAMERA, depth, mask, points, image.gravity)
    item = SimpleNamespace(position=0, obj_id=3, points=points, view=looked_at, bonus=0.0)
    proposals = SimpleNamespace(
        candidates=Candidates(quat_wxyz_from_matrix(gt[:3, :3])[None, None], gt[None, None, :3, 3], np.ones((1, 1))),
        trusted=all_of,
    )
    found = VerificationRefiner({3: box().mesh()}, {3: HALF_TURN}, FitConfig(), 0)(gt[None], [item], proposals)[0]
    assert errors(found, gt)[1] < 5.0
