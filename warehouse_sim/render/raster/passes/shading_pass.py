"""The full-screen passes from geometry buffer to colour: soft light on fewer pixels, then each visible pixel once."""

import moderngl
import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raster.context import FullScreen
from warehouse_sim.render.raster.light.lighting import UNITS, LightBlock, Lighting, Variant
from warehouse_sim.render.raster.passes.geometry_pass import GeometryBuffer
from warehouse_sim.render.raster.projection import NEAR, window_intrinsics

_OCCLUSION_TAPS = 8
_SHADOW_TAPS = 6
_GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))


class SoftLight:
    """The textures of one image size."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        half = (size[0] + 1) // 2, (size[1] + 1) // 2
        self.depth = context.texture(half, 1, dtype="f4")
        self._raw_near_light, self.near_light = (context.texture(half, 1, alignment=1) for _ in range(2))
        self._raw_visibility = [context.texture(half, 4) for _ in range(2)]
        self.around = context.texture(half, 4, dtype="f2")
        self.visibility = [context.texture(half, 4) for _ in range(2)]
        self._textures = [self.depth, self._raw_near_light, self.near_light, self.around]
        self._textures += [*self._raw_visibility, *self.visibility]
        for texture in self._textures:
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self.depth.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.raw = context.framebuffer([self.depth, self._raw_near_light, self.around, *self._raw_visibility])
        self.softened = context.framebuffer([self.near_light, *self.visibility])

    def use(self) -> None:
        """Bind the textures to the units that the shaders read them from."""
        self.depth.use(UNITS["soft_depth"])
        self._raw_near_light.use(UNITS["raw_near_light"])
        self.near_light.use(UNITS["near_light"])
        self.around.use(UNITS["around"])
        for letter, raw, softened in zip("ab", self._raw_visibility, self.visibility, strict=True):
            raw.use(UNITS[f"raw_visibility_{letter}"])
            softened.use(UNITS[f"visibility_{letter}"])


class SoftLightPass:
    """Fills a ``SoftLight`` from the geometry buffer."""

    def __init__(self, context: moderngl.Context, block: LightBlock) -> None:
        self._context, self._block = context, block
        self._shaders: dict[int, FullScreen] = {}
        self._soften = FullScreen(context, "surface.glsl", "pack.glsl", "upsample.glsl", "soften.frag")
        self._soften.assign(near=NEAR, **UNITS)
        self._targets: SoftLight | None = None

    def draw(
        self, geometry: GeometryBuffer, camera: PinholeCamera, T_world_camera: Transform, lighting: Lighting
    ) -> None:
        """Compute the soft light of what ``geometry`` holds and leave it bound for the passes that follow."""
        targets = self._targets_for(geometry.size)
        shader = self._shader_for(lighting)
        intrinsics = window_intrinsics(camera)
        self._block.bind(lighting, T_world_camera)
        geometry.depth.use(UNITS["depth_map"])
        geometry.surface.use(UNITS["surface_map"])
        shader.assign(intrinsics=intrinsics, **lighting.uniforms(T_world_camera))
        shader.draw(targets.raw)
        targets.use()
        self._soften.assign(intrinsics=intrinsics)
        self._soften.draw(targets.softened)

    def _shader_for(self, lighting: Lighting) -> FullScreen:
        """Return the shader for this many shadow maps, compiled when first requested."""
        count = lighting.variant[1]
        if count not in self._shaders:
            files = (
                "surface.glsl",
                "pack.glsl",
                "even_ribs.glsl",
                "lights.glsl",
                "shadow_filter.glsl",
                "occlusion.glsl",
            )
            constants = lighting.constants() | {
                "OCCLUSION_TAPS": _OCCLUSION_TAPS,
                "OCCLUSION_DISK": spiral(_OCCLUSION_TAPS, 1.0),
                "SHADOW_TAPS": _SHADOW_TAPS,
                "SHADOW_DISK": spiral(_SHADOW_TAPS, 0.5),
            }
            shader = FullScreen(self._context, *files, "field.glsl", "contact.glsl", "soft.frag", **constants)
            shader.assign(near=NEAR, **UNITS)
            self._shaders[count] = shader
        return self._shaders[count]

    def _targets_for(self, size: tuple[int, int]) -> SoftLight:
        if self._targets is None or self._targets.size != size:
            self._targets = SoftLight(self._context, size)
        return self._targets


def spiral(count: int, power: float) -> str:
    """Return GLSL for points in the unit disk on the golden spiral (Vogel 1979).

    Args:
        count: Number of points.
        power: Of the fraction of points within a radius; 0.5 spreads them evenly, 1 denser towards the middle.
    """
    k = np.arange(count)
    radius, angle = ((k + 0.5) / count) ** power, k * _GOLDEN_ANGLE
    points = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return ", ".join(f"vec2({x:.6f}, {y:.6f})" for x, y in points)


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
        shader.assign(intrinsics=window_intrinsics(camera), eye_height=float(T_world_camera[2, 3]))
        shader.assign(**lighting.uniforms(T_world_camera))
        self._draw(shader, target, geometry)

    def render_normals(self, target: moderngl.Framebuffer, geometry: GeometryBuffer) -> None:
        """Fill ``target`` with unit normals of the geometry in the camera frame."""
        self._draw(self._normals, target, geometry)

    def _draw(self, shader: FullScreen, target: moderngl.Framebuffer, geometry: GeometryBuffer) -> None:
        geometry.depth.use(UNITS["depth_map"])
        geometry.surface.use(UNITS["surface_map"])
        geometry.paint.use(UNITS["paint_map"])
        shader.draw(target)

    def _shader_for(self, lighting: Lighting) -> FullScreen:
        """Return the shader for this many lights and shadows, compiled when first requested."""
        if lighting.variant not in self._shaders:
            files = ("surface.glsl", "pack.glsl", "fine.glsl", "upsample.glsl", "lights.glsl", "lighting.glsl")
            shader = FullScreen(self._context, *files, "fine_detail.glsl", "shade.frag", **lighting.constants())
            shader.assign(near=NEAR, **UNITS)
            self._shaders[lighting.variant] = shader
        return self._shaders[lighting.variant]
