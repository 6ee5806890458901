import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import invert, level_camera, transform_points
from warehouse_sim.render.conformance.scenes import MATERIALS, rack_wall
from warehouse_sim.render.raster.meshes.parts import ObjectIndex, build_part_table

ROWS = {name: row for row, name in enumerate(MATERIALS)}
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
