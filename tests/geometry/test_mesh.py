"""Meshes, even and not."""

import numpy as np
import pytest
import trimesh

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.clouds import cloud_to_depth, depth_normals, depth_to_cloud, thin_by_voxels
from warehouse_sim.geometry.mesh import (
    TriangleMesh,
    diameter,
    grid_box,
    merge,
    sample_surface,
    split_long_edges,
    unit_box,
)


def test_unit_box_faces_point_outwards_and_are_watertight() -> None:
    box = unit_box()
    centres = box.vertices[box.faces].mean(axis=1)
    assert (np.einsum("ij,ij->i", box.face_normals(), centres) > 0).all()
    assert box.face_areas().sum() == pytest.approx(6.0)
    edges = np.concatenate([box.faces[:, [0, 1]], box.faces[:, [1, 2]], box.faces[:, [2, 0]]])
    directed = {tuple(edge) for edge in edges}
    assert len(directed) == len(edges)
    assert all((b, a) in directed for a, b in directed)


def test_merge_keeps_every_triangle() -> None:
    box = unit_box()
    both = merge([box, TriangleMesh(box.vertices + 5.0, box.faces)])
    assert both.face_areas().sum() == pytest.approx(12.0)
    assert both.vertices.max() == 5.5


def test_surface_samples_lie_on_the_box_and_are_uniform_by_area() -> None:
    box = TriangleMesh(unit_box().vertices * [4.0, 2.0, 1.0], unit_box().faces)
    points, normals = sample_surface(box, 20_000, np.random.default_rng(0))
    on_face = np.abs(np.abs(points) / [2.0, 1.0, 0.5] - 1.0) < 1e-9
    assert on_face.any(axis=1).all()
    fraction_top = (normals[:, 2] > 0.5).mean()
    assert fraction_top == pytest.approx(8 / 28, abs=0.012)  # 4 standard deviations


@pytest.mark.parametrize("count", [1, 2, 700, 1200])
@pytest.mark.parametrize("shape", ["ball", "box", "line", "cloud"])
def test_diameter_is_that_of_every_pair(shape: str, count: int) -> None:
    rng = np.random.default_rng([count, len(shape)])
    points = rng.normal(size=(count, 3))
    if shape == "ball":
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    elif shape == "box":
        points = np.clip(points, -0.6, 0.6)
    elif shape == "line":
        points[:, 1:] = 3.0
    every = ((points[:, None] - points[None]) ** 2).sum(axis=-1)
    assert diameter(points) == float(np.sqrt(every.max()))  # to the last bit: datasets store it


def edge_lengths(mesh: TriangleMesh) -> np.ndarray:
    corners = mesh.vertices[mesh.faces]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)


@pytest.mark.parametrize("spacing", [10.0, 0.5, 0.11, 0.05])
def test_grid_box_is_the_same_solid(spacing: float) -> None:
    size = np.array([1.2, 0.145, 0.022])
    mesh = grid_box(size, spacing)
    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert solid.is_watertight
    assert solid.volume == pytest.approx(size.prod(), rel=1e-12)
    assert solid.area == pytest.approx(2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]), rel=1e-12)
    assert np.allclose(solid.bounds, [-size / 2, size / 2], rtol=0, atol=1e-15)
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    # Each triangle is half of a grid cell, whose sides are at most the spacing.
    assert edge_lengths(mesh).max() <= spacing * np.sqrt(2) + 1e-12 or spacing > size.max()


@pytest.mark.parametrize("longest", [0.7, 0.2, 0.09])
def test_split_long_edges_keeps_the_solid(longest: float) -> None:
    box = TriangleMesh(unit_box().vertices * [1.3, 0.4, 0.1], unit_box().faces)
    mesh = split_long_edges(box, longest)
    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert edge_lengths(mesh).max() <= longest
    assert solid.is_watertight
    assert solid.volume == pytest.approx(1.3 * 0.4 * 0.1, rel=1e-12)
    assert solid.area == pytest.approx(box.face_areas().sum(), rel=1e-12)


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
