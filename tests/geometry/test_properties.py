"""What holds for every transform and every lens, on examples that Hypothesis looks for."""

import cv2
import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import (
    invert,
    make_transform,
    matrix_from_quat_wxyz,
    quat_wxyz_from_matrix,
    rotation_angle,
    transform_points,
)

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
