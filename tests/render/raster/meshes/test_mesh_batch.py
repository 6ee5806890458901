"""Levels of detail of meshes, and the edges of their faces."""

import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh, grid_box, merge, unit_box
from warehouse_sim.geometry.pose import invert, level_camera, transform_points
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene
from warehouse_sim.render.conformance.subject import cast_image
from warehouse_sim.render.raster.meshes.mesh_batch import LEVEL_ERROR_PX, choose_levels, flat_mesh, mesh_levels
from warehouse_sim.render.raster.meshes.parts import build_part_table, placed_records
from warehouse_sim.schema import ObjectModel, Part, SceneSpec

ROWS = {name: row for row, name in enumerate(MATERIALS)}
CAMERA = PinholeCamera.from_focal(1224, 370, 721.5377)


def printed_carton() -> ObjectModel:
    """A carton with twenty bars of print on its front, each 2 mm thick."""
    box = unit_box()
    bars = [
        TriangleMesh(box.vertices * [0.002, 0.02, 0.2] + [-0.301, 0.025 * (k - 9.5), 0.0], box.faces) for k in range(20)
    ]
    model = box_model("carton", (0.6, 0.6, 0.4))
    ink = Part(merge(bars), np.ones(3), np.eye(4), "concrete")
    return ObjectModel("carton", "carton", 1, model.size, (*model.parts, ink), ())


def row_of(distances: tuple[float, ...]) -> SceneSpec:
    return make_scene([printed_carton()], [("carton", at(d, 0.7 * (k - 2), 0)) for k, d in enumerate(distances)])


def test_the_level_follows_the_error_in_pixels() -> None:
    distances = (1.5, 3.0, 6.0, 12.0, 24.0)
    scene, T = row_of(distances), level_camera(np.zeros(3), 0.0)
    table = build_part_table(scene, ROWS)
    errors = [mesh_levels(mesh).errors for mesh in table.meshes]
    records = placed_records(table, T)
    levels = choose_levels(table, errors, records, CAMERA)
    parts = scene.models["carton"].parts
    for rows, limits, part in zip(table.rows_of_mesh, errors, parts, strict=True):
        for row, instance in zip(range(rows.start, rows.stop), scene.instances, strict=True):
            points = transform_points(invert(T) @ instance.T_world_object, part.placed().vertices)
            assert limits[levels[row]] * CAMERA.fx / points[:, 2].min() <= LEVEL_ERROR_PX
    ink = table.rows_of_mesh[1]
    assert levels[table.rows_of_mesh[0]].tolist() == [0] * 5  # a box has one level
    assert levels[ink].tolist() == sorted(levels[ink].tolist())
    assert set(levels[ink].tolist()) == {0, 1}


@pytest.mark.gl
def test_far_cartons_look_as_exact_rays_see_them(renderer: Renderer) -> None:
    scene = row_of((4.0, 6.0, 9.0, 14.0, 20.0))
    renderer.load(scene)
    T = level_camera(np.array([0.0, 0.3, 0.3]), 0.05, -0.03)
    buffers = renderer.render(CAMERA, T, normals=True)
    gt = cast_image(scene, CAMERA, T)
    same = buffers.instance_mask == gt.instance_mask
    assert same.mean() > 0.9995
    seen = same & (gt.instance_mask > 0)
    assert np.quantile(np.abs(buffers.depth - gt.depth)[seen] / gt.depth[seen], 0.999) < 0.001
    for instance, amodal_mask in zip(scene.instances, renderer.amodal_masks(CAMERA, T, scene.instances), strict=True):
        left, top = amodal_mask.offset
        rows, columns = np.nonzero(buffers.instance_mask == instance.instance_id)
        assert amodal_mask.mask[rows - top, columns - left].all()


def rendered_normals(mesh: TriangleMesh) -> tuple[np.ndarray, np.ndarray]:
    """Return twice the area vector of each drawn triangle and the normal that its first corner holds."""
    flat = flat_mesh(mesh)
    a, b, c = np.moveaxis(flat.corners["position"][flat.triangles].astype(float), 1, 0)
    return np.cross(b - a, c - a), flat.corners["normal"][flat.triangles[:, 0]]


def test_a_box_needs_24_corners_and_each_edge_is_zero_on_itself() -> None:
    flat = flat_mesh(unit_box())
    assert len(flat.corners) == 24
    assert flat.triangles.shape == (12, 3)
    for normal in np.unique(flat.corners["normal"], axis=0):
        face = flat.corners[(flat.corners["normal"] == normal).all(axis=1)]
        # Four corners of a face: each lies on two of its edges, each edge holds two corners.
        assert (np.count_nonzero(face["to_edge"] == 0, axis=1) == 2).all()
        assert (np.count_nonzero(face["to_edge"] == 0, axis=0) == 2).all()


@pytest.mark.parametrize("mesh", [unit_box(), unit_cylinder(24), grid_box(np.array([1.0, 0.5, 0.2]), 0.1)])
def test_the_surface_stays_the_same(mesh: TriangleMesh) -> None:
    crosses, normals = rendered_normals(mesh)
    assert np.linalg.norm(crosses, axis=1).sum() / 2 == pytest.approx(mesh.face_areas().sum(), rel=1e-6)
    unit = crosses / np.linalg.norm(crosses, axis=1, keepdims=True)
    np.testing.assert_allclose(unit, normals, atol=2e-6)


def test_lines_between_coplanar_triangles_are_no_edges() -> None:
    """Every edge of a box that is cut into a grid lies on the outline of the box."""
    size = np.array([1.0, 0.5, 0.2])
    flat = flat_mesh(grid_box(size, 0.1))
    corner = np.abs(flat.corners["position"]) > size / 2 - 1e-6
    inside_face = corner.sum(axis=1) == 1
    assert inside_face.any()
    assert (flat.corners["to_edge"][inside_face] > 0).all()
    on_outline = corner.sum(axis=1) >= 2
    assert (flat.corners["to_edge"][on_outline] == 0).any(axis=1).mean() > 0.8


def test_triangles_without_area_are_left_out() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], float)
    flat = flat_mesh(TriangleMesh(points, np.array([[0, 1, 2], [0, 1, 3]], np.int32)))
    assert len(flat.triangles) == 1
    assert flat.corners["to_edge"].tolist().count([0, 0, 0, 255]) == 0
    assert sorted(flat.corners["to_edge"].tolist()) == [[0, 0, 255, 255], [0, 255, 0, 255], [255, 0, 0, 255]]
