"""What decides how bright surfaces are, bound for the programs that include ``lighting.glsl``."""

from dataclasses import dataclass
from typing import NamedTuple

import moderngl
import numpy as np

from warehouse_sim.color import LUMINANCE
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.light_selection import GROUND
from warehouse_sim.render.raster.light.light_textures import DistributionTexture, FieldTexture
from warehouse_sim.render.raster.light.lights import LIGHT, MAX_LIGHTS, ShadedLight, light_records
from warehouse_sim.render.raster.light.shadows import ATLAS_PX, BLOCK_TEXELS, SHADOW_NEAR, ShadowAtlas
from warehouse_sim.render.raster.surfaces.materials import MaterialTable
from warehouse_sim.render.raster.surfaces.textures import TEXTURE_EDGE_PX

UNITS = {
    "depth_map": 0,
    "surface_map": 1,
    "materials": 2,
    "textures": 3,
    "shadow_atlas": 4,
    "field": 5,
    "shadow_blockers": 14,
    "paint_map": 15,
    "distributions": 16,
} | {
    name: 6 + number
    for number, name in enumerate(
        (
            "soft_depth",
            "raw_near_light",
            "near_light",
            "around",
            "visibility_a",
            "visibility_b",
            "raw_visibility_a",
            "raw_visibility_b",
        )
    )
}
"""Texture units of the samplers in the shaders."""


class Variant(NamedTuple):
    """What the programs that shade are compiled for."""

    lights: int
    shadows: int
    """Of the lights, those with a shadow map."""
    distributions: bool
    """Whether any light has one."""
    retroreflectors: bool
    """Whether lights near the camera are thrown back to it."""


@dataclass(frozen=True, eq=False)
class Lighting:
    """All that decides how bright a surface is."""

    lights: list[ShadedLight]
    """Those with a shadow map first."""
    shadows: ShadowAtlas
    materials: MaterialTable
    field: FieldTexture
    """Light from the surroundings."""
    ambient: float
    """Illuminance (lx) of the even light from above."""
    exposure: float
    """Linear image value of 1 cd/m^2."""
    distributions: DistributionTexture | None = None
    """Those of the scene's lights; None where all are cones."""
    retroreflectors: bool = False
    """Whether lights near the camera are thrown back to it."""

    @property
    def variant(self) -> Variant:
        """What needs a program of its own."""
        shadows = sum(item.tile is not None for item in self.lights)
        return Variant(len(self.lights), shadows, self.distributions is not None, self.retroreflectors)

    def constants(self) -> dict[str, object]:
        """Return the definitions that ``lighting.glsl`` and what includes it are compiled with."""
        count, shadows, distributions, retroreflectors = self.variant
        seen = [f"seen[{i // 4}][{i % 4}]" for i in range(shadows)]
        calls = [f"add_light({i}, {seen[i] if i < shadows else 1.0}, s, direct);" for i in range(count)]
        return {
            "MAX_LIGHTS": MAX_LIGHTS,
            "DISTRIBUTIONS": int(distributions),
            "RETROREFLECTORS": int(retroreflectors),
            "ATLAS_PX": float(ATLAS_PX),
            "LUMINANCE": f"vec3{tuple(LUMINANCE.tolist())}",
            "SHADOW_NEAR": SHADOW_NEAR,
            "BLOCK_TEXELS": float(BLOCK_TEXELS),
            "TEXTURE_PX": TEXTURE_EDGE_PX,
            "ADD_LIGHTS": " ".join(calls),
            "ADD_SHADOWS": " ".join(f"{name} = visibility({i}, p, n, turn);" for i, name in enumerate(seen)),
        }

    def uniforms(self, T_world_camera: Transform) -> dict[str, object]:
        """Return the uniforms of ``lighting.glsl``, ``field.glsl`` and the sky for a view."""
        sky = self.ambient / np.pi
        view = {"up": tuple(T_world_camera[2, :3]), "sky": sky, "ground": GROUND * sky, "exposure": self.exposure}
        return view | self.field.uniforms(T_world_camera)


class LightBlock:
    """The lights in a uniform block, and the textures beside them."""

    def __init__(self, context: moderngl.Context) -> None:
        self._lights = context.buffer(reserve=LIGHT.itemsize * MAX_LIGHTS)

    def bind(self, lighting: Lighting, T_world_camera: Transform) -> None:
        """Place the lights in the camera frame and bind all that ``lighting.glsl`` reads."""
        self._lights.write(light_records(lighting.lights, T_world_camera).tobytes())
        self._lights.bind_to_uniform_block(0)
        lighting.materials.values.use(UNITS["materials"])
        lighting.materials.library.array.use(UNITS["textures"])
        lighting.shadows.depth.use(UNITS["shadow_atlas"])
        lighting.shadows.blockers.use(UNITS["shadow_blockers"])
        lighting.field.texture.use(UNITS["field"])
        if lighting.distributions is not None:
            lighting.distributions.texture.use(UNITS["distributions"])

    def release(self) -> None:
        """Free the device memory."""
        self._lights.release()
