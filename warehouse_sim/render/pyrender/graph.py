"""A scene as pyrender's scene graph, twice in one: instanced for the image, a node an object for the ids."""

from typing import Any

import numpy as np

from warehouse_sim.render.light_selection import reference_points, strongest_lights
from warehouse_sim.render.painted_mesh import PaintedMesh, painted_meshes
from warehouse_sim.render.pyrender.appearance import MaterialCache, ambient_light, background, make_light
from warehouse_sim.render.pyrender.device import import_pyrender
from warehouse_sim.schema import ObjectInstance, SceneSpec

MAX_LIGHTS = 8
NEAR, FAR = 0.05, 1000.0
"""Distances of the clipping planes (m).

Depth is 24-bit fixed point with most of its steps close by: one step is z^2 / (near 2^24), 12 mm at 100 m.
"""


class SceneGraph:
    """What pyrender draws of a scene.

    The image is made of one primitive for each mesh and material, drawn at all its poses by one call; ids can only be
    given to nodes, so each object has one more, which the image leaves out. Both stay uploaded.
    """

    def __init__(self, scene: SceneSpec) -> None:
        self.scene = scene
        pyrender = import_pyrender()
        materials = MaterialCache(scene.materials, scene.exposure)
        self.graph = pyrender.Scene(bg_color=background(scene), ambient_light=ambient_light(scene))
        self.node_of: dict[int, Any] = {}
        """Node that draws each instance id; an object that is all film has none."""
        self._painted: list[Any] = []
        self._plain: list[Any] = []
        for instances in _by_look(scene):
            meshes = painted_meshes(scene.painted_model_of(instances[0]), scene.materials)
            poses = np.stack([item.T_world_object for item in instances])
            # Film would cast the shadow of a board, for a renderer that cannot leave single meshes out of its shadows.
            solid = {key: mesh for key, mesh in meshes.items() if scene.materials[key].opacity >= 1.0}
            if solid:
                self._add_painted([_primitive(mesh, materials[key], poses) for key, mesh in solid.items()])
                self._add_plain(list(solid.values()), instances)
        for light in strongest_lights(scene.lights, MAX_LIGHTS, reference_points(scene)):
            node, T_world_light = make_light(light, scene.exposure)
            self.graph.add(node, pose=T_world_light)
        self.camera = pyrender.IntrinsicsCamera(1.0, 1.0, 0.0, 0.0, znear=NEAR, zfar=FAR)
        self.eye = self.graph.add(self.camera, pose=np.eye(4))

    def show(self, plain: bool) -> None:
        """Show the objects' own nodes, for ids, or the instanced primitives, for the image."""
        for mesh in self._plain:
            mesh.is_visible = plain
        for mesh in self._painted:
            mesh.is_visible = not plain

    def _add_painted(self, primitives: list[Any]) -> None:
        mesh = import_pyrender().Mesh(primitives)
        self._painted.append(mesh)
        self.graph.add(mesh)

    def _add_plain(self, solid: list[PaintedMesh], instances: list[ObjectInstance]) -> None:
        pyrender = import_pyrender()
        mesh = pyrender.Mesh([_bare_primitive(solid)])
        self._plain.append(mesh)
        for item in instances:
            self.node_of[item.instance_id] = self.graph.add(mesh, pose=item.T_world_object)


def _by_look(scene: SceneSpec) -> list[list[ObjectInstance]]:
    groups: dict[Any, list[ObjectInstance]] = {}
    for instance in scene.instances:
        groups.setdefault(instance.look, []).append(instance)
    return [group for group in groups.values() if scene.model_of(group[0]).parts]


def _primitive(mesh: PaintedMesh, material: Any, poses: np.ndarray) -> Any:
    return import_pyrender().Primitive(
        positions=mesh.positions,
        normals=mesh.normals,
        texcoord_0=mesh.tiles if material.baseColorTexture is not None else None,
        indices=mesh.faces,
        material=material,
        poses=poses,
    )


def _bare_primitive(meshes: list[PaintedMesh]) -> Any:
    starts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes[:-1]])
    return import_pyrender().Primitive(
        positions=np.concatenate([mesh.positions for mesh in meshes]),
        indices=np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]),
    )
