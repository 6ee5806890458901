import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import invert, level_camera, transform_points
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, pallet_model, rack_wall
from warehouse_sim.render.raster.meshes.object_index import ObjectIndex
from warehouse_sim.render.raster.meshes.parts import build_part_table

ROWS = {name: row for row, name in enumerate(MATERIALS)}
CAMERA = PinholeCamera.from_focal(320, 200, 200.0)


def test_every_object_knows_its_rows_in_the_order_requested_for() -> None:
    models = [pallet_model(), box_model("box", (1, 2, 3))]
    scene = make_scene(models, [("box", at(0, 0, 0)), ("pallet", at(1, 2, 3)), ("box", at(5, 5, 0))])
    table = build_part_table(scene, ROWS)
    rows, owner = ObjectIndex.of(table).rows_of([3, 2, 3])
    requested = np.array([3, 2, 3])
    assert (np.diff(rows) >= 0).all()
    assert np.array_equal(table.template["identity"][rows, 0], requested[owner])
    assert np.bincount(owner).tolist() == [1, len(scene.models["pallet"].parts), 1]


def test_spheres_hold_their_objects() -> None:
    scene = rack_wall()
    index = ObjectIndex.of(build_part_table(scene, ROWS))
    for instance in scene.instances:
        k = index.number[instance.instance_id]
        vertices = transform_points(instance.T_world_object, scene.model_of(instance).mesh().vertices)
        assert (np.linalg.norm(vertices - index.centre[k], axis=1) <= index.radius[k] + 1e-9).all()


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
