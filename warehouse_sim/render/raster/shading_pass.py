"""One full-screen pass that turns the geometry buffer into colour, each visible pixel once."""

from dataclasses import dataclass

import moderngl

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raster.geometry_pass import GeometryBuffer
from warehouse_sim.render.raster.lights import LIGHT, MAX_LIGHTS, ShadedLight, light_records
from warehouse_sim.render.raster.materials import TEXTURE_EDGE_PX, MaterialTable
from warehouse_sim.render.raster.programs import FullScreen
from warehouse_sim.render.raster.projection import NEAR, window_intrinsics
from warehouse_sim.render.raster.shadows import ATLAS_PX, SHADOW_NEAR

_UNITS = {"depth_map": 0, "surface_map": 1, "materials": 2, "textures": 3, "shadow_atlas": 4}


@dataclass(frozen=True, eq=False)
class Lighting:
    """All that decides how bright a surface is."""

    lights: list[ShadedLight]
    """Those with a shadow map first."""
    shadow_atlas: moderngl.Texture
    materials: MaterialTable
    ambient: float
    """Illuminance (lx) of the even light from above."""
    exposure: float
    """Linear image value of 1 cd/m^2."""


class ShadingPass:
    """Metallic-roughness shading in linear light, tone mapped to sRGB; and the normals, on request."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._shaders: dict[tuple[int, int], FullScreen] = {}
        self._normals = FullScreen(context, "surface.glsl", "normals.frag")
        self._normals.assign(**_UNITS)
        self._lights = context.buffer(reserve=LIGHT.itemsize * MAX_LIGHTS)

    def shade(
        self,
        target: moderngl.Framebuffer,
        geometry: GeometryBuffer,
        camera: PinholeCamera,
        T_world_camera: Transform,
        lighting: Lighting,
    ) -> None:
        """Fill ``target`` with the picture of what ``geometry`` holds."""
        shader = self._shader_for(lighting)
        self._lights.write(light_records(lighting.lights, T_world_camera).tobytes())
        self._lights.bind_to_uniform_block(0)
        lighting.materials.values.use(_UNITS["materials"])
        lighting.materials.textures.use(_UNITS["textures"])
        lighting.shadow_atlas.use(_UNITS["shadow_atlas"])
        shader.assign(
            intrinsics=window_intrinsics(camera),
            up=tuple(T_world_camera[2, :3]),
            ambient=lighting.ambient,
            exposure=lighting.exposure,
        )
        self._draw(shader, target, geometry)

    def draw_normals(self, target: moderngl.Framebuffer, geometry: GeometryBuffer) -> None:
        """Fill ``target`` with unit normals in the camera frame."""
        self._draw(self._normals, target, geometry)

    def release(self) -> None:
        """Free the device memory."""
        for shader in (*self._shaders.values(), self._normals):
            shader.release()
        self._lights.release()

    def _draw(self, shader: FullScreen, target: moderngl.Framebuffer, geometry: GeometryBuffer) -> None:
        geometry.depth.use(_UNITS["depth_map"])
        geometry.surface.use(_UNITS["surface_map"])
        shader.draw(target)

    def _shader_for(self, lighting: Lighting) -> FullScreen:
        """Return the shader for this many lights and shadows, compiled when first asked for."""
        shadows = sum(item.tile is not None for item in lighting.lights)
        key = len(lighting.lights), shadows
        if key not in self._shaders:
            calls = [f"radiance += reflected({i}, {str(i < shadows).lower()}, s);" for i in range(key[0])]
            shader = FullScreen(
                self._context,
                "surface.glsl",
                "shade.frag",
                MAX_LIGHTS=MAX_LIGHTS,
                ATLAS_PX=float(ATLAS_PX),
                SHADOW_NEAR=SHADOW_NEAR,
                TEXTURE_PX=TEXTURE_EDGE_PX,
                ADD_LIGHTS=" ".join(calls),
            )
            shader.assign(near=NEAR, **_UNITS)
            self._shaders[key] = shader
        return self._shaders[key]
