import numpy as np
import pytest

from warehouse_sim.geometry.mesh import TriangleMesh, diameter, merge, sample_surface, unit_box


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


@pytest.mark.parametrize("count", [1, 2, 700, 2500])
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
