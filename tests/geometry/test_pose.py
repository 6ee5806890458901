"""Transforms and their groups."""

import cv2
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import (
    invert,
    level_camera,
    look_at,
    make_transform,
    matrix_from_quat_wxyz,
    quat_wxyz_from_matrix,
    rotation_angle,
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


# What holds for every transform and every lens, on examples that Hypothesis looks for.


metres = st.floats(-100.0, 100.0)
quaternions = arrays(float, 4, elements=st.floats(-1.0, 1.0)).filter(lambda q: np.linalg.norm(q) > 1e-3)
clouds = arrays(float, (5, 3), elements=metres)
transforms = st.builds(make_transform, quaternions.map(matrix_from_quat_wxyz), arrays(float, 3, elements=metres))
lenses = st.builds(
    Distortion,
    k1=st.floats(-0.5, 0.5),
    k2=st.floats(-0.3, 0.3),
    p1=st.floats(-0.005, 0.005),
    p2=st.floats(-0.005, 0.005),
    k3=st.floats(-0.1, 0.1),
)


@given(quaternions)
def test_a_quaternion_is_the_rotation_that_scipy_makes_of_it_and_back(quat_wxyz: np.ndarray) -> None:
    R = matrix_from_quat_wxyz(quat_wxyz)
    np.testing.assert_allclose(R, Rotation.from_quat(np.roll(quat_wxyz, -1)).as_matrix(), atol=1e-12)
    back = quat_wxyz_from_matrix(R)
    assert back[0] >= 0.0
    np.testing.assert_allclose(matrix_from_quat_wxyz(back), R, atol=1e-9)


@given(quaternions, quaternions)
def test_the_angle_between_rotations_is_that_of_scipy(a: np.ndarray, b: np.ndarray) -> None:
    R_a, R_b = matrix_from_quat_wxyz(a), matrix_from_quat_wxyz(b)
    expected = Rotation.from_matrix(R_a.T @ R_b).magnitude()
    np.testing.assert_allclose(rotation_angle(R_a, R_b), expected, atol=1e-6)


@given(transforms, transforms, clouds)
def test_neighbours_cancel_and_distances_stay(T_a_b: np.ndarray, T_b_c: np.ndarray, points: np.ndarray) -> None:
    np.testing.assert_allclose(transform_points(invert(T_a_b), transform_points(T_a_b, points)), points, atol=1e-10)
    chained = transform_points(T_a_b, transform_points(T_b_c, points))
    np.testing.assert_allclose(transform_points(T_a_b @ T_b_c, points), chained, atol=1e-10)
    spans = [np.linalg.norm(cloud - np.roll(cloud, 1, axis=0), axis=1) for cloud in (points, chained)]
    np.testing.assert_allclose(spans[1], spans[0], atol=1e-10)


@given(lenses, arrays(float, (20, 2), elements=st.floats(-0.4, 0.4)))
def test_a_lens_shows_what_opencv_shows_and_takes_it_back(lens: Distortion, xy: np.ndarray) -> None:
    shown = lens.apply(xy)
    np.testing.assert_allclose(lens.remove(shown), xy, atol=1e-8)
    believed = np.hypot(*xy.T) < lens.radius
    assume(believed.any())
    points = np.column_stack([xy, np.ones(len(xy))])[believed]
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), np.array(lens.coefficients))
    np.testing.assert_allclose(shown[believed], expected[:, 0], atol=1e-12)


@given(lenses, arrays(float, (20, 3), elements=st.floats(-0.3, 0.3)))
def test_every_ray_of_a_camera_leads_back_to_its_pixel(lens: Distortion, points: np.ndarray) -> None:
    camera = PinholeCamera(64, 48, 80.0, 78.0, 31.5, 23.5, lens)
    u, v = camera.project(points + np.array([0.0, 0.0, 1.0])).T
    np.testing.assert_allclose(camera.project(camera.rays_at(u, v)), np.column_stack([u, v]), atol=1e-6)
