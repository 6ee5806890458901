"""Transforms and their groups."""

import numpy as np
import pytest

from warehouse_sim.geometry.pose import (
    level_camera,
    look_at,
    make_transform,
    matrix_from_quat_wxyz,
    quat_wxyz_from_matrix,
    rotation_z,
    transform_points,
)
from warehouse_sim.geometry.symmetry import SymmetryGroup


def random_transform(rng: np.random.Generator) -> np.ndarray:
    return make_transform(matrix_from_quat_wxyz(rng.normal(size=4)), rng.normal(size=3))


def test_transform_points_agrees_with_homogeneous_product_for_batches() -> None:
    rng = np.random.default_rng(1)
    T = np.stack([random_transform(rng) for _ in range(3)])
    points = rng.normal(size=(3, 5, 3))
    expected = np.einsum("bij,bnj->bni", T, np.concatenate([points, np.ones((3, 5, 1))], -1))[..., :3]
    np.testing.assert_allclose(transform_points(T, points), expected, atol=1e-14)


def test_quaternion_round_trip_at_half_turns() -> None:
    for R in (np.diag([1.0, -1, -1]), np.diag([-1.0, 1, -1]), np.diag([-1.0, -1, 1]), np.eye(3)):
        quat_wxyz = quat_wxyz_from_matrix(R)
        assert quat_wxyz[0] >= 0
        np.testing.assert_allclose(matrix_from_quat_wxyz(quat_wxyz), R, atol=1e-12)


def test_level_camera_looks_along_its_heading_with_image_down_being_world_down() -> None:
    T = level_camera(np.array([1.0, 2.0, 3.0]), yaw=np.pi / 2)
    np.testing.assert_allclose(T[:3, 2], [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(T[:3, 1], [0, 0, -1], atol=1e-15)
    np.testing.assert_allclose(T[:3, 0], [1, 0, 0], atol=1e-15)


def test_positive_pitch_looks_up() -> None:
    assert level_camera(np.zeros(3), yaw=0.0, pitch=0.1)[2, 2] == pytest.approx(np.sin(0.1))


@pytest.mark.parametrize("target", [(3.0, 1.0, 0.2), (-2.0, 5.0, 1.0), (1.0, 2.0, 0.0), (1.0, 2.0, 9.0)])
def test_a_camera_looks_at_a_point_upright(target: tuple[float, float, float]) -> None:
    position = np.array([1.0, 2.0, 1.5])
    T = look_at(position, np.array(target))
    np.testing.assert_array_equal(T[:3, 3], position)
    np.testing.assert_allclose(T[:3, 2], (target - position) / np.linalg.norm(target - position), atol=1e-12)
    assert T[2, 0] == pytest.approx(0.0, abs=1e-12)  # no roll: the image's rows are level
    assert T[2, 1] <= 1e-12  # and its upper border is up


def test_a_camera_cannot_look_at_itself() -> None:
    with pytest.raises(ValueError, match="where it is"):
        look_at(np.ones(3), np.ones(3))


@pytest.mark.parametrize(
    ("group", "size"),
    [
        (SymmetryGroup.trivial(), 1),
        (SymmetryGroup.turns("z", 2), 2),
        (SymmetryGroup.turns("x", 5), 5),
        (SymmetryGroup.cuboid(), 4),
    ],
)
def test_groups_are_closed_and_start_with_identity(group, size) -> None:
    assert len(group) == size
    np.testing.assert_array_equal(group.transforms[0], np.eye(4))
    for a in group.transforms:
        for b in group.transforms:
            assert np.abs(group.transforms - a @ b).max(axis=(1, 2)).min() < 1e-12


def test_equivalents_compose_on_the_object_side() -> None:
    T = make_transform(rotation_z(0.3), np.array([1.0, 2, 3]))
    poses = SymmetryGroup.turns("z", 2).equivalents(T)
    np.testing.assert_allclose(poses[1], make_transform(rotation_z(0.3 + np.pi), np.array([1.0, 2, 3])), atol=1e-12)
