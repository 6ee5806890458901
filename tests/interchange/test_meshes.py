"""A scene as trimesh's: every object where it stands, in the colours of its materials."""

import numpy as np

import warehouse_sim as ws
from warehouse_sim.color import srgb_from_linear
from warehouse_sim.geometry.pose import transform_points


def test_every_object_is_where_it_stands_in_its_colours() -> None:
    scene = ws.Scene()
    for x in (0.0, 3.0):
        scene.add("epal1", x=x, yaw_deg=10 * x)
    scene.add("carton_600x400x300", x=1.5)
    found, spec = scene.to_trimesh(), scene.spec
    assert len(found.graph.nodes_geometry) == sum(bool(spec.model_of(item).parts) for item in spec.instances)
    looks = {item.look for item in spec.instances if spec.model_of(item).parts}
    assert len(found.geometry) == len(looks) < len(spec.instances)
    for item in spec.instances:
        model = spec.model_of(item)
        T_world_object, name = found.graph[f"{item.instance_id:06d}_{model.class_name}"]
        mesh = found.geometry[name]
        seen, expected = transform_points(T_world_object, mesh.vertices), model.mesh().vertices
        np.testing.assert_allclose(seen, transform_points(item.T_world_object, expected), atol=1e-9)
        first, last = model.parts[0], model.parts[-1]
        for part, row in ((first, 0), (last, -1)):
            linear = np.clip(spec.materials[item.material_of(part)].base_color, 0.0, 1.0)
            np.testing.assert_allclose(mesh.visual.face_colors[row, :3], 255 * srgb_from_linear(linear), atol=0.51)
