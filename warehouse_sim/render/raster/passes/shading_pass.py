"""One full-screen pass that turns the geometry buffer into colour, each visible pixel once."""

import moderngl

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raster.light.lighting import UNITS, LightBlock, Lighting, Variant
from warehouse_sim.render.raster.passes.geometry_pass import GeometryBuffer
from warehouse_sim.render.raster.passes.soft_light import SoftLightPass
from warehouse_sim.render.raster.programs import FullScreen
from warehouse_sim.render.raster.projection import NEAR, window_intrinsics


class ShadingPass:
    """Metallic-roughness shading in linear light, tone mapped to sRGB; and the normals, on request."""

    def __init__(self, context: moderngl.Context, block: LightBlock) -> None:
        self._context = context
        self._soft_light = SoftLightPass(context, block)
        self._shaders: dict[Variant, FullScreen] = {}
        self._normals = FullScreen(context, "surface.glsl", "pack.glsl", "normals.frag")
        self._normals.assign(**UNITS)

    def shade(
        self,
        target: moderngl.Framebuffer,
        geometry: GeometryBuffer,
        camera: PinholeCamera,
        T_world_camera: Transform,
        lighting: Lighting,
    ) -> None:
        """Fill ``target`` with the image of what ``geometry`` holds."""
        self._soft_light.draw(geometry, camera, T_world_camera, lighting)
        shader = self._shader_for(lighting)
        shader.assign(intrinsics=window_intrinsics(camera), **lighting.uniforms(T_world_camera))
        self._draw(shader, target, geometry)

    def draw_normals(self, target: moderngl.Framebuffer, geometry: GeometryBuffer) -> None:
        """Fill ``target`` with unit normals of the geometry in the camera frame."""
        self._draw(self._normals, target, geometry)

    def release(self) -> None:
        """Free the device memory."""
        self._soft_light.release()
        for shader in (*self._shaders.values(), self._normals):
            shader.release()

    def _draw(self, shader: FullScreen, target: moderngl.Framebuffer, geometry: GeometryBuffer) -> None:
        geometry.depth.use(UNITS["depth_map"])
        geometry.surface.use(UNITS["surface_map"])
        geometry.paint.use(UNITS["paint_map"])
        shader.draw(target)

    def _shader_for(self, lighting: Lighting) -> FullScreen:
        """Return the shader for this many lights and shadows, compiled when first requested."""
        if lighting.variant not in self._shaders:
            files = ("surface.glsl", "pack.glsl", "upsample.glsl", "lights.glsl", "lighting.glsl", "shade.frag")
            shader = FullScreen(self._context, *files, **lighting.constants())
            shader.assign(near=NEAR, **UNITS)
            self._shaders[lighting.variant] = shader
        return self._shaders[lighting.variant]
