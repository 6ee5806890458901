import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.clouds import cloud_to_depth, depth_normals, depth_to_cloud, thin_by_voxels

CAMERA = PinholeCamera(64, 48, 60.0, 62.0, 30.3, 24.8)


def tilted_plane() -> tuple[np.ndarray, np.ndarray]:
    """Return the depth of the plane n x = -2 and its normal n, which faces the camera."""
    normal = np.array([0.3, -0.5, -0.8])
    normal /= np.linalg.norm(normal)
    return -2.0 / (CAMERA.rays() @ normal), normal


def test_depth_to_cloud_and_back_is_the_same_image() -> None:
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.5, 9.0, (48, 64)) * (rng.random((48, 64)) > 0.2)
    points, pixels = depth_to_cloud(depth, CAMERA)
    assert len(points) == np.count_nonzero(depth)
    np.testing.assert_allclose(CAMERA.project(points), np.stack([pixels % 64, pixels // 64], axis=1), atol=1e-9)
    again, index = cloud_to_depth(points, CAMERA)
    assert np.array_equal(again, depth)
    assert np.array_equal(index.ravel()[pixels], np.arange(len(points)))
    assert (index[depth == 0] == -1).all()


def test_cloud_to_depth_and_back_is_the_same_cloud_to_half_a_pixel() -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform([-2, -2, 1], [2, 2, 9], (400, 3))
    depth, index = cloud_to_depth(points, CAMERA)
    again, pixels = depth_to_cloud(depth, CAMERA)
    shown = points[index.ravel()[pixels]]
    assert np.array_equal(again[:, 2], shown[:, 2])
    assert np.abs(CAMERA.project(again) - CAMERA.project(shown)).max() <= 0.5 + 1e-9


def test_the_nearest_point_hides_others_and_what_is_not_in_the_image_is_left_out() -> None:
    ray = CAMERA.rays()[10, 20]
    points = np.array([5.0 * ray, 2.0 * ray, 2.0 * ray, 3.0 * ray, -1.0 * ray, [0, 0, 0], [50.0, 0, 1.0]])
    depth, index = cloud_to_depth(points, CAMERA)
    assert depth[10, 20] == pytest.approx(2.0)
    assert index[10, 20] == 1
    assert np.count_nonzero(depth) == 1
    empty, none = cloud_to_depth(np.zeros((0, 3)), CAMERA)
    assert not empty.any()
    assert (none == -1).all()


def test_normals_of_a_plane_are_its_own_and_unknown_at_edges() -> None:
    depth, normal = tilted_plane()
    normals = depth_normals(depth, CAMERA, max_jump=0.2)
    np.testing.assert_allclose(normals[1:-1, 1:-1], np.broadcast_to(normal, (46, 62, 3)), atol=1e-9)
    assert not normals[0].any()
    assert not normals[:, -1].any()
    depth[20:30, 20:30] *= 0.5
    depth[40, 40] = 0.0
    known = depth_normals(depth, CAMERA, max_jump=0.2).any(axis=-1)
    assert not known[20:30, [19, 20, 29, 30]].any()
    assert not known[[39, 40, 41, 40, 40], [40, 40, 40, 39, 41]].any()
    assert known[21:29, 21:29].all()
    assert known[39, 39]


def test_voxels_hold_their_means() -> None:
    points = np.array([[0.1, 0.1, 0.1], [0.3, 0.1, 0.1], [-0.1, 0.1, 0.1], [1.2, 0.0, 0.0]])
    means, group = thin_by_voxels(points, 0.5)
    assert group.tolist() == [1, 1, 0, 2]
    np.testing.assert_allclose(means, [[-0.1, 0.1, 0.1], [0.2, 0.1, 0.1], [1.2, 0.0, 0.0]])
    rng = np.random.default_rng(2)
    points = rng.normal(size=(5000, 3))
    means, group = thin_by_voxels(points, 0.3)
    assert np.abs(points - means[group]).max() <= 0.3
    assert np.array_equal(np.floor(means / 0.3), np.unique(np.floor(points / 0.3), axis=0))
    assert thin_by_voxels(np.zeros((0, 3)), 0.1)[0].shape == (0, 3)
    with pytest.raises(ValueError, match="must be positive, found 0"):
        thin_by_voxels(points, 0)
