"""Write a scene as binary glTF: each geometry once, each object as a node."""

from pathlib import Path

import numpy as np

from warehouse_sim.geometry.pose import make_transform, rotation_x
from warehouse_sim.optional import require
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import SceneSpec

# glTF is y up.
_T_GLTF_WORLD = make_transform(rotation_x(-np.pi / 2), np.zeros(3))


def write_glb(scene: SceneSpec, path: Path) -> Path:
    """Write ``scene`` to ``path`` with metallic-roughness materials; nodes are named by instance id and class.

    Materials are plain: textures and pictures of labels and prints are left out.

    Raises:
        MissingPackageError: trimesh is not installed.
        OutputError: The file cannot be written.
    """
    trimesh = require("trimesh", "interchange", "to write GLB")
    visual = require("trimesh.visual", "interchange", "to write GLB")
    materials = {
        name: visual.material.PBRMaterial(
            name=name,
            baseColorFactor=[*material.base_color, 1.0],
            metallicFactor=material.metallic,
            roughnessFactor=material.roughness,
        )
        for name, material in scene.materials.items()
    }
    graph = trimesh.Scene(base_frame="world")
    for instance in scene.instances:
        model = scene.model_of(instance)
        for index, part in enumerate(model.parts):
            material = instance.material_of(part)
            painted = "" if material == part.material else f" in {material}"
            name = f"{instance.model}/{index}{painted}"
            node = f"{instance.instance_id:06d}_{model.class_name}/{index}"
            T = _T_GLTF_WORLD @ instance.T_world_object
            if name in graph.geometry:
                graph.graph.update(frame_from="world", frame_to=node, geometry=name, matrix=T)
                continue
            placed = part.placed()
            # Vertices are not shared between faces, so that edges stay sharp.
            mesh = trimesh.Trimesh(
                placed.vertices[placed.faces].reshape(-1, 3),
                np.arange(3 * len(placed.faces)).reshape(-1, 3),
                process=False,
            )
            mesh.visual = visual.TextureVisuals(material=materials[material])
            graph.add_geometry(mesh, node_name=node, geom_name=name, transform=T)
    make_folder(path.parent)
    write_bytes(path, graph.export(file_type="glb"))
    return path
