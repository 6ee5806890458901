"""The raster backend: one context, one loaded scene, any number of views."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import cv2
import moderngl
import numpy as np

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.render.painted_mesh import require_renderable
from warehouse_sim.render.raster.amodal_mask_atlas import AmodalMaskAtlas
from warehouse_sim.render.raster.context import describe, open_context
from warehouse_sim.render.raster.light.contact import ContactMapper
from warehouse_sim.render.raster.light.lighting import MAX_LIGHTS, LightBlock
from warehouse_sim.render.raster.light.shadows import ShadowAtlas
from warehouse_sim.render.raster.loaded_scene import LoadedScene
from warehouse_sim.render.raster.meshes.mesh_batch import MeshLibrary
from warehouse_sim.render.raster.meshes.parts import placed_records
from warehouse_sim.render.raster.passes.antialias import EdgeSmoother
from warehouse_sim.render.raster.passes.film_pass import FilmPass
from warehouse_sim.render.raster.passes.geometry_pass import GeometryBuffer, GeometryPass
from warehouse_sim.render.raster.passes.shading_pass import ShadingPass
from warehouse_sim.render.raster.projection import MAX_IMAGE_PX, NEAR, window_viewport
from warehouse_sim.render.raster.surfaces import PictureLibrary, TextureLibrary
from warehouse_sim.render.renderer import AmodalMask, Capabilities, ClosingRenderer, loaded, require_view, still_open
from warehouse_sim.schema import NO_COLOR, ObjectInstance, RenderBuffers, SceneSpec


class ImageTargets:
    """Geometry buffer, colour and normals of one image size."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        self._smoother = EdgeSmoother(size)
        self.geometry = GeometryBuffer(context, size)
        self._color_texture = context.texture(size, 4)
        self._normal_texture = context.texture(size, 4, dtype="f4")
        self.color = context.framebuffer([self._color_texture])
        self.normals = context.framebuffer([self._normal_texture])
        self.film = context.framebuffer([self._color_texture], self.geometry.depth)
        self.film.depth_mask = False
        self.film.viewport = window_viewport(size)

    def read(self, normals: bool, color: bool) -> RenderBuffers:
        """Return what was rendered."""
        width, height = self.size
        instance_mask, stored = np.empty((height, width), np.int32), np.empty((height, width), np.float32)
        self.geometry.instance_mask.read_into(instance_mask)
        self.geometry.exact_depth.read_into(stored)
        return RenderBuffers(
            rgb=self._read_color(stored) if color else NO_COLOR,
            depth=np.divide(np.float32(NEAR), stored, out=np.zeros_like(stored), where=stored > 0),
            instance_mask=instance_mask,
            normals=self._read_normals() if normals else None,
        )

    def _read_color(self, stored: np.ndarray) -> np.ndarray:
        width, height = self.size
        rgba, reach = np.empty((height, width, 4), np.uint8), np.empty((height, width, 4), np.uint8)
        self._color_texture.read_into(rgba)
        self.geometry.reach.read_into(reach)
        self._smoother.smooth(rgba, reach, stored)
        return cv2.cvtColor(rgba, cv2.COLOR_RGBA2RGB)

    def _read_normals(self) -> np.ndarray:
        width, height = self.size
        values = np.empty((height, width, 4), np.float32)
        self._normal_texture.read_into(values)
        return np.ascontiguousarray(values[..., :3])


@dataclass(frozen=True)
@ranged
class RasterOptions:
    """Options of the raster backend."""

    device: Annotated[int, Range(0, 1023)] = 0
    """Number of the EGL device, 0-1,023; 0 = the first."""


class RasterRenderer(ClosingRenderer):
    """Deferred renderer on OpenGL 4.5; see ``render.renderer.Renderer`` for the methods.

    Args:
        options: Which device draws.

    Raises:
        RenderError: No context can be opened.
    """

    Options = RasterOptions

    def __init__(self, options: RasterOptions | None = None) -> None:
        self._context: moderngl.Context | None = open_context((options or RasterOptions()).device)
        self.description = f"raster on {describe(self._context)}"
        with self._context:
            self._geometry = GeometryPass(self._context)
            self._block = LightBlock(self._context)
            self._shading = ShadingPass(self._context, self._block)
            self._film = FilmPass(self._context, self._block)
            self._textures = TextureLibrary(self._context)
            self._pictures = PictureLibrary(self._context)
            self._meshes = MeshLibrary(self._context)
            self._shadows = ShadowAtlas(self._context)
            self._contacts = ContactMapper(self._context)
            self._amodal_masks = AmodalMaskAtlas(self._context)
        self._scene: LoadedScene | None = None
        self._targets: ImageTargets | None = None

    @property
    def capabilities(self) -> Capabilities:
        """All products; the light of other surfaces is approximated."""
        return Capabilities(max_lights=MAX_LIGHTS, without_color=True)

    def load(self, scene: SceneSpec) -> None:
        """Upload ``scene``, but for what did not change since the scene before; its light follows with a colour."""
        with still_open(self._context) as context:
            before = self._scene
            if before is None or not before.holds_what(scene):
                require_renderable(scene)
            self._scene = LoadedScene(
                context,
                scene,
                self._shadows,
                self._contacts,
                self._textures,
                self._pictures,
                self._meshes,
                before,
            )
            del before
            context.gc()

    def render(
        self, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False, color: bool = True
    ) -> RenderBuffers:
        """Render the loaded scene; light and shadows are prepared when the first colours are drawn."""
        require_view(camera, T_world_camera)
        with still_open(self._context) as context:
            scene, targets = loaded(self._scene), self._targets_for(context, camera)
            batches = scene.batches
            table = scene.table.subset(scene.objects.in_view(camera, T_world_camera))
            records = placed_records(table, T_world_camera)
            self._geometry.draw(targets.geometry, camera, table, records, batches, scene.materials)
            if color:
                lighting, depth = scene.lighting(T_world_camera), targets.geometry.depth
                self._shading.shade(targets.color, targets.geometry, camera, T_world_camera, lighting)
                self._film.draw(targets.film, depth, camera, T_world_camera, table, records, batches, lighting)
            if normals:
                self._shading.render_normals(targets.normals, targets.geometry)
            buffers = targets.read(normals, color)
            error = context.error  # reading it clears it
            if error != "GL_NO_ERROR":
                raise RenderError(
                    f"{self.description} failed while drawing ({error}); try another device or LIBGL_ALWAYS_SOFTWARE=1"
                )
            return buffers

    def amodal_masks(
        self, camera: PinholeCamera, T_world_camera: Transform, instances: Sequence[ObjectInstance]
    ) -> list[AmodalMask]:
        """Draw each of ``instances`` of the loaded scene as if it stood alone."""
        require_view(camera, T_world_camera)
        with still_open(self._context) as context:
            scene = loaded(self._scene)
            rows, owner = scene.objects.rows_of([instance.instance_id for instance in instances])
            solid = ~scene.table.film[rows]
            table, owner = scene.table.subset(rows[solid]), owner[solid]
            records = placed_records(table, T_world_camera)
            masks = self._amodal_masks.draw(camera, table, records, scene.batches, owner, len(instances))
            context.gc()
            return masks

    def close(self) -> None:
        """Give back the context and all device memory."""
        if self._context is None:
            return
        self._context.release()
        self._context = self._scene = self._targets = None

    def _targets_for(self, context: moderngl.Context, camera: PinholeCamera) -> ImageTargets:
        size = (camera.width, camera.height)
        if max(size) > MAX_IMAGE_PX:
            raise RenderError(
                f"an image of {size[0]} x {size[1]} is too large; the raster backend renders {MAX_IMAGE_PX} px"
            )
        if self._targets is None or self._targets.size != size:
            self._targets = ImageTargets(context, size)
            self._targets.color.use()  # a bound framebuffer must not be freed: making the next one would bind it again
            context.gc()
        return self._targets
