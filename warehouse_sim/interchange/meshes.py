"""A whole scene as trimesh's: a mesh for each look, a node for each object."""

from typing import TYPE_CHECKING, Any

import numpy as np

from warehouse_sim.color import srgb_from_linear
from warehouse_sim.schema import ObjectInstance, SceneSpec

if TYPE_CHECKING:
    import trimesh


def to_trimesh(scene: SceneSpec) -> "trimesh.Scene":
    """Return a scene in the world's axes (m, z up), its objects in the plain colours of their materials.

    Nodes are named by instance id and class, as in GLB, which also has textures, lights and cameras.
    """
    import trimesh

    found = trimesh.Scene()
    looks: dict[object, str] = {}
    for item in (item for item in scene.instances if scene.model_of(item).parts):
        node = f"{item.instance_id:06d}_{scene.model_of(item).class_name}"
        if item.look in looks:
            found.graph.update(frame_to=node, matrix=item.T_world_object, geometry=looks[item.look])
            continue
        looks[item.look] = f"{item.model}_{len(looks)}"
        found.add_geometry(_mesh(scene, item), node, looks[item.look], transform=item.T_world_object)
    return found


def _mesh(scene: SceneSpec, item: ObjectInstance) -> Any:
    import trimesh

    model = scene.model_of(item)
    whole = model.mesh()
    colors = [_color(scene, item.material_of(part)) for part in model.parts]
    faces = np.repeat(colors, [len(part.placed().faces) for part in model.parts], axis=0)
    return trimesh.Trimesh(whole.vertices, whole.faces, face_colors=faces, process=False)


def _color(scene: SceneSpec, material: str) -> np.ndarray:
    look = scene.materials[material]
    color = srgb_from_linear(np.clip(np.asarray(look.base_color, float), 0.0, 1.0))
    return np.round(255 * np.append(color, look.opacity)).astype(np.uint8)
