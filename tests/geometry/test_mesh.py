"""Meshes, even and not."""

import numpy as np
import pytest
import trimesh

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
