"""The pyrender backend: one context a process, one loaded scene, any number of views."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int32

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.render.canvas_tiles import amodal_mask_by_tiles
from warehouse_sim.render.light_selection import reference_points, strongest_lights
from warehouse_sim.render.painted_mesh import PaintedMesh, painted_meshes, require_renderable
from warehouse_sim.render.pyrender.appearance import MaterialCache, ambient_light, background, display_table, make_light
from warehouse_sim.render.pyrender.device import close_offscreen, import_pyrender, open_offscreen
from warehouse_sim.render.renderer import AmodalMask, Capabilities, ClosingRenderer, loaded, require_view, still_open
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneSpec

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


_FLIP = np.diag([1.0, -1.0, -1.0, 1.0])
"""From OpenCV's camera axes to OpenGL's, y up and z backwards."""


@dataclass(frozen=True)
@ranged
class PyrenderOptions:
    """Options of the pyrender backend."""

    device: Annotated[int, Range(0, 1023)] = 0
    """Number of the EGL device, 0-1,023; 0 = the first."""
    shadows: bool = True
    """Whether spots cast shadows; pyrender knows all or none."""


class PyrenderRenderer(ClosingRenderer):
    """pyrender through EGL; see ``render.renderer.Renderer`` for the methods. A process can have one open.

    Args:
        options: What draws, and whether with shadows.

    Raises:
        RenderError: No context can be opened, or another renderer of this kind is open.
        MissingPackageError: pyrender is not installed.
    """

    Options = PyrenderOptions

    def __init__(self, options: PyrenderOptions | None = None) -> None:
        options = options or PyrenderOptions()
        self._offscreen, package_and_driver = open_offscreen(options.device)
        self.description = package_and_driver
        self._shadows = options.shadows
        self._graph: SceneGraph | None = None
        self._display = display_table()

    @property
    def capabilities(self) -> Capabilities:
        """No normals, which pyrender draws as lines only, and no film, which would cast shadows."""
        return Capabilities(normals=False, film=False, shadows=self._shadows, max_lights=MAX_LIGHTS)

    def load(self, scene: SceneSpec) -> None:
        """Build the scene graph; pyrender uploads it with the first image."""
        still_open(self._offscreen)
        require_renderable(scene)
        self._graph = SceneGraph(scene)

    def render(self, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False) -> RenderBuffers:
        """Render the loaded scene: one pass for the image, one without antialiasing for depth and instance mask."""
        require_view(camera, T_world_camera)
        graph = self._loaded()
        if normals:
            raise RenderError("the pyrender backend renders no normals; use raster or pathtrace")
        self._aim(graph, camera, T_world_camera)
        flags = import_pyrender().RenderFlags
        graph.show(plain=False)
        rgb, _ = self._offscreen.render(graph.graph, flags.SHADOWS_SPOT if self._shadows else flags.NONE)
        instance_mask, depth = self._render_instance_mask(graph, graph.node_of)
        return RenderBuffers(
            rgb=cv2.LUT(np.ascontiguousarray(rgb), self._display), depth=depth, instance_mask=instance_mask
        )

    def amodal_masks(
        self, camera: PinholeCamera, T_world_camera: Transform, instances: Sequence[ObjectInstance]
    ) -> list[AmodalMask]:
        """Draw each of ``instances`` of the loaded scene alone, which takes a pass for each."""
        require_view(camera, T_world_camera)
        graph = self._loaded()
        return [self._amodal_mask(graph, camera, T_world_camera, instance) for instance in instances]

    def close(self) -> None:
        """Free all device memory; the context stays for the next renderer of the process."""
        if self._offscreen is not None:
            close_offscreen()
        self._offscreen = self._graph = None

    def _amodal_mask(
        self, graph: SceneGraph, camera: PinholeCamera, T_world_camera: Transform, instance: ObjectInstance
    ) -> AmodalMask:
        node = graph.node_of.get(instance.instance_id)

        def draw(tile: PinholeCamera) -> Bool[np.ndarray, "h w"]:
            self._aim(graph, tile, T_world_camera)
            return self._render_instance_mask(graph, {1: node})[0] == 1

        return amodal_mask_by_tiles(camera, T_world_camera, graph.scene, instance, NEAR, draw)

    def _render_instance_mask(
        self, graph: SceneGraph, nodes: dict[int, Any]
    ) -> tuple[Int32[np.ndarray, "h w"], Float32[np.ndarray, "h w"]]:
        """Render the given nodes in the colours of their numbers; return the numbers and depth (m).

        pyrender2 switches multisampling off for segmentation, so that all samples of a pixel are that of its centre.
        """
        colors = {node: (number & 255, number >> 8 & 255, number >> 16) for number, node in nodes.items()}
        graph.show(plain=True)
        pixels, depth = self._offscreen.render(graph.graph, import_pyrender().RenderFlags.SEG, colors)
        instance_mask = pixels.astype(np.int32) @ np.array([1, 1 << 8, 1 << 16], np.int32)
        return instance_mask, np.ascontiguousarray(depth, np.float32)

    def _aim(self, graph: SceneGraph, camera: PinholeCamera, T_world_camera: Transform) -> None:
        """Look through ``camera``; pyrender counts pixels from their edges."""
        self._offscreen.viewport_width, self._offscreen.viewport_height = camera.width, camera.height
        eye = graph.camera
        eye.fx, eye.fy, eye.cx, eye.cy = camera.fx, camera.fy, camera.cx + 0.5, camera.cy + 0.5
        graph.graph.set_pose(graph.eye, T_world_camera @ _FLIP)

    def _loaded(self) -> SceneGraph:
        still_open(self._offscreen)
        return loaded(self._graph)
