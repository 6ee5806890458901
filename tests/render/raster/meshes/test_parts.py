"""The rows of a part table, and the objects that they belong to."""

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import invert, level_camera, transform_points
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, pallet_model, rack_wall
from warehouse_sim.render.raster.meshes.parts import ObjectIndex, build_part_table, placed_records

ROWS = {name: row for row, name in enumerate(MATERIALS)}


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


CAMERA = PinholeCamera.from_focal(320, 200, 200.0)


def test_nothing_in_the_image_is_left_out_and_what_is_behind_is() -> None:
    scene = rack_wall()
    table = build_part_table(scene, ROWS)
    index = ObjectIndex.of(table)
    for viewpoint in scene.viewpoints:
        T = viewpoint.T_world_camera
        kept = set(table.template["identity"][index.in_view(CAMERA, T), 0].tolist())
        for instance in scene.instances:
            T_camera_object = invert(T) @ instance.T_world_object
            points = transform_points(T_camera_object, scene.model_of(instance).mesh().vertices)
            u, v = CAMERA.project(points[points[:, 2] > 0.05]).T
            if ((u > -0.5) & (u < CAMERA.width - 0.5) & (v > -0.5) & (v < CAMERA.height - 0.5)).any():
                assert instance.instance_id in kept
    away = index.in_view(CAMERA, level_camera(np.array([-40.0, 0.0, 1.6]), np.pi))
    assert len(away) == 0
