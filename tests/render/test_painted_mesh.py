import numpy as np
import pytest

from warehouse_sim.errors import RenderError
from warehouse_sim.render.conformance.scenes import MATERIALS, box_model, pallet_model
from warehouse_sim.render.mujoco.model import lit_at_vertices, tessellate
from warehouse_sim.render.painted_mesh import PaintedMesh, painted_meshes
from warehouse_sim.render.textures import albedo_factor, box_projection


def areas(mesh: PaintedMesh) -> np.ndarray:
    a, b, c = np.moveaxis(mesh.positions[mesh.faces], 1, 0)
    return np.cross(b - a, c - a) / 2


def test_a_model_becomes_one_mesh_a_material_with_all_its_surface() -> None:
    model = pallet_model()
    (mesh,) = painted_meshes(model, MATERIALS).values()
    assert len(mesh.faces) == 12 * len(model.parts)
    assert np.linalg.norm(areas(mesh), axis=1).sum() == pytest.approx(model.mesh().face_areas().sum())
    np.testing.assert_allclose(np.ptp(mesh.positions, axis=0), model.size)
    # Outward faces with the normals of their corners.
    facing = (areas(mesh) / np.linalg.norm(areas(mesh), axis=1, keepdims=True))[:, None]
    np.testing.assert_allclose((facing * mesh.normals[mesh.faces]).sum(axis=2), 1.0)


def test_textures_run_along_the_longest_edge_at_their_own_size() -> None:
    (mesh,) = painted_meshes(box_model("board", (2.0, 0.5, 0.02)), MATERIALS).values()
    top = mesh.normals[:, 2] > 0.9
    np.testing.assert_allclose(np.ptp(mesh.tiles[top], axis=0), [2.0, 0.5])
    slope = np.polyfit(mesh.positions[top, 0], mesh.tiles[top, 0], 1)[0]
    assert slope == pytest.approx(1.0)


def test_u_runs_along_the_longest_edge_and_v_turns_with_the_face() -> None:
    """A board 2 m long in y, 1 m in x: on its top u is y and v is -x, underneath v is x."""
    corners = np.array([[[0.5, 1.0, 0.1], [-0.5, 1.0, 0.1], [0.5, -1.0, 0.1]]] * 2)
    normals = np.array([[[0.0, 0.0, 1.0]], [[0.0, 0.0, -1.0]]])
    tiles = box_projection(corners, normals, np.array([1, 0, 2]))
    np.testing.assert_allclose(tiles[0], [[1.0, -0.5], [1.0, 0.5], [-1.0, -0.5]])
    np.testing.assert_allclose(tiles[1], [[1.0, 0.5], [1.0, -0.5], [-1.0, 0.5]])


def test_finer_triangles_cover_the_same_surface_without_gaps() -> None:
    (mesh,) = painted_meshes(box_model("floor", (5.0, 4.0, 0.1)), MATERIALS).values()
    fine = tessellate(mesh, 1.0)
    corners = fine.positions[fine.faces]
    assert np.linalg.norm(np.roll(corners, 1, axis=1) - corners, axis=2).max() <= 1.0
    assert np.linalg.norm(areas(fine), axis=1).sum() == pytest.approx(np.linalg.norm(areas(mesh), axis=1).sum())
    # Every edge has a paired variant: no corner of one triangle lies within the edge of another.
    ends = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).round(9).reshape(-1, 2, 3), axis=1)
    key = np.concatenate([ends.sum(axis=1), np.abs(ends[:, 0] - ends[:, 1])], axis=1).round(6)
    assert (np.unique(key, axis=0, return_counts=True)[1] == 2).all()


def test_small_things_keep_their_triangles() -> None:
    (mesh,) = painted_meshes(pallet_model(), MATERIALS).values()
    assert lit_at_vertices(mesh) is mesh


def test_a_texture_that_is_not_shipped_is_named() -> None:
    with pytest.raises(RenderError, match="texture 'marble'"):
        albedo_factor("marble")
