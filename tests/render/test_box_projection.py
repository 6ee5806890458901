"""The path tracer lays textures out like the rasteriser."""

import numpy as np
import pytest

pytest.importorskip("mitsuba")
from warehouse_sim.render.conformance.scenes import rack_wall
from warehouse_sim.render.pathtrace.triangles import edge_order, texture_shift, tile_coordinates
from warehouse_sim.render.raster.meshes.parts import build_part_table


def test_shift_and_order_are_those_of_the_raster_backend() -> None:
    scene = rack_wall()
    table = build_part_table(scene, {name: row for row, name in enumerate(scene.materials)})
    sampled = [
        (instance, number, part)
        for instance in scene.instances
        for number, part in enumerate(scene.model_of(instance).parts)
    ]
    ids, numbers = np.array([item[0].instance_id for item in sampled]), np.array([item[1] for item in sampled])
    extent = np.stack([np.ptp(part.mesh.vertices, axis=0) * part.scale for _, _, part in sampled])
    # All parts share one mesh, so the rows are in the order of the scene.
    np.testing.assert_array_equal(table.template["identity"][:, 0], ids)
    np.testing.assert_allclose(texture_shift(ids, numbers), table.template["texture_shift"], atol=1e-6)
    np.testing.assert_array_equal(edge_order(extent) @ [1, 4, 16], table.template["identity"][:, 2])


def test_u_runs_along_the_longest_edge_and_v_turns_with_the_face() -> None:
    """A board 2 m long in y, 1 m in x: on its top u is y and v is -x, underneath v is x."""
    corners = np.array([[[[0.5, 1.0, 0.1], [-0.5, 1.0, 0.1], [0.5, -1.0, 0.1]]] * 2])
    normals = np.array([[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    tiles = tile_coordinates(corners, normals, np.array([[1, 0, 2]]))[0]
    np.testing.assert_allclose(tiles[0], [[1.0, -0.5], [1.0, 0.5], [-1.0, -0.5]])
    np.testing.assert_allclose(tiles[1], [[1.0, 0.5], [1.0, -0.5], [-1.0, 0.5]])
