"""Levels of detail of meshes, and the edges of their faces."""

import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh, grid_box, merge, unit_box
from warehouse_sim.geometry.pose import invert, level_camera, transform_points
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import (
    MATERIALS,
    at,
    box_model,
    box_part,
    make_scene,
    pallet_model,
    rack_wall,
)
from warehouse_sim.render.conformance.subject import cast_image
from warehouse_sim.render.mujoco.model import lit_at_vertices, tessellate
from warehouse_sim.render.painted_mesh import PaintedMesh, painted_meshes
from warehouse_sim.render.raster.meshes.mesh_batch import LEVEL_ERROR_PX, choose_levels, flat_mesh, mesh_levels
from warehouse_sim.render.raster.meshes.parts import ObjectIndex, build_part_table, placed_records, shadow_casters
from warehouse_sim.render.textures import albedo_factor, box_projection
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


# The rows of a part table, and the objects that they belong to.


def test_every_part_is_a_row_and_every_mesh_one_slice() -> None:
    scene = make_scene([pallet_model(), box_model("box", (1, 2, 3))], [("box", at(0, 0, 0)), ("pallet", at(1, 2, 3))])
    table = build_part_table(scene, ROWS)
    count = 1 + len(scene.models["pallet"].parts)
    assert len(table) == count
    assert len(table.meshes) == 1  # all are the unit box
    assert table.rows_of_mesh == (slice(0, count),)
    assert table.template["identity"][:, 0].tolist() == [1] + [2] * (count - 1)
    first = table.template["identity"][0].tolist()
    assert [*first[:2], first[2] & 63, first[3]] == [1, ROWS["kraft"], 2 + 4 * 1 + 16 * 0, 0]


def test_records_place_vertices_where_the_scene_has_them() -> None:
    T_world_camera = level_camera(np.array([-3.0, 1.0, 1.5]), 0.4, -0.2)
    scene = make_scene([pallet_model()], [("pallet", at(1, 2, 3, 0.7))])
    table = build_part_table(scene, ROWS)
    records = placed_records(table, T_world_camera)
    pallet = scene.instances[0]
    for record, part in zip(records, scene.models["pallet"].parts, strict=True):
        sampled = (part.mesh.vertices * record["scale"]) @ record["rotation"] + record["translation"]
        true = transform_points(invert(T_world_camera) @ pallet.T_world_object, part.placed().vertices)
        np.testing.assert_allclose(sampled, true, atol=1e-6)
    tops = [(part.T_object_part[2, 3] + part.scale[2] / 2) + 3 for part in scene.models["pallet"].parts]
    np.testing.assert_allclose(table.tops(), tops, atol=1e-12)


def test_edges_that_are_equal_to_the_centimetre_keep_their_order() -> None:
    """The body of a carton is a skin's thickness less wide than it is high: its grain must not turn for that."""
    orders = {}
    for edges in ((0.599, 0.399, 0.3995), (0.599, 0.3995, 0.399), (0.3, 0.4, 0.6)):
        scene = make_scene([box_model("box", edges)], [("box", at(0, 0, 0))])
        orders[edges] = int(build_part_table(scene, ROWS).template["identity"][0, 2]) & 63
    assert list(orders.values()) == [0 + 4 * 1 + 16 * 2, 0 + 4 * 1 + 16 * 2, 2 + 4 * 1 + 16 * 0]


PARTS_CAMERA = PinholeCamera.from_focal(320, 200, 200.0)


def test_nothing_in_the_image_is_left_out_and_what_is_behind_is() -> None:
    scene = rack_wall()
    table = build_part_table(scene, ROWS)
    index = ObjectIndex.of(table)
    for viewpoint in scene.viewpoints:
        T = viewpoint.T_world_camera
        kept = set(table.template["identity"][index.in_view(PARTS_CAMERA, T), 0].tolist())
        for instance in scene.instances:
            T_camera_object = invert(T) @ instance.T_world_object
            points = transform_points(T_camera_object, scene.model_of(instance).mesh().vertices)
            u, v = PARTS_CAMERA.project(points[points[:, 2] > 0.05]).T
            if ((u > -0.5) & (u < PARTS_CAMERA.width - 0.5) & (v > -0.5) & (v < PARTS_CAMERA.height - 0.5)).any():
                assert instance.instance_id in kept
    away = index.in_view(PARTS_CAMERA, level_camera(np.array([-40.0, 0.0, 1.6]), np.pi))
    assert len(away) == 0


def model(*parts: Part) -> ObjectModel:
    return ObjectModel("m", "carton", 1, np.ones(3), parts, ())


def test_skin_on_a_box_casts_nothing_and_what_stands_out_does() -> None:
    body = box_part((0.6, 0.4, 0.3), material="kraft")
    tape = box_part((0.601, 0.05, 0.301))
    handle = box_part((0.1, 0.02, 0.02), at=(0.0, 0.21, 0.0))
    inside = box_part((0.1, 0.1, 0.1))
    assert shadow_casters(model(tape, body, handle, inside), MATERIALS).tolist() == [False, True, True, False]
    print_ = catalog_object("carton_300x200x150")
    casts = shadow_casters(print_, materials())
    by_material = {part.material: bool(casts[number]) for number, part in enumerate(print_.parts)}
    assert by_material["kraft_dark"]
    assert not by_material["print_blue"]
    assert not by_material["label_paper"]


def test_of_two_equal_boxes_one_casts_and_film_never_does() -> None:
    pallet = catalog_object("epal1")
    assert shadow_casters(pallet, materials()).sum() > 15
    wrap = catalog_object("wrap_1200x800x1000")
    assert not shadow_casters(wrap, materials()).any()


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
