"""What decides how bright surfaces are, bound for the programs that include ``lighting.glsl``."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import moderngl
import numpy as np
from jaxtyping import Float16

from warehouse_sim.color import LUMINANCE
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.render.irradiance import FieldLevel, IrradianceField
from warehouse_sim.render.light_selection import GROUND, map_ramp
from warehouse_sim.render.raster.light.contact import ContactMap
from warehouse_sim.render.raster.light.shadows import ATLAS_PX, BLOCK_TEXELS, SHADOW_NEAR, ShadowAtlas, ShadowTile
from warehouse_sim.render.raster.surfaces import TEXTURE_EDGE_PX, MaterialTable
from warehouse_sim.schema import IntensityDistribution, Light


class DistributionTexture:
    """The different distributions of some lights: angle from the axis along u, half plane, which repeats, along v."""

    def __init__(self, context: moderngl.Context, distributions: Sequence[IntensityDistribution]) -> None:
        self._distributions = list(distributions)
        layers = np.stack([item.fraction for item in self._distributions])
        count, planes, angles = layers.shape
        self.texture = context.texture_array((angles, planes, count), 1, layers.tobytes(), dtype="f4")
        self.texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self.texture.repeat_x, self.texture.repeat_y = False, True

    def layer(self, light: Light) -> int | None:
        """Return the layer of a light's distribution, None where it has none."""
        same = (number for number, item in enumerate(self._distributions) if item is light.distribution)
        return next(same, None)


def distributions_of(lights: Sequence[Light]) -> list[IntensityDistribution]:
    """Return the different distributions of ``lights``, in the order of the lights."""
    found = {id(light.distribution): light.distribution for light in lights}
    return [item for item in found.values() if item is not None]


class FieldTexture:
    """A volume of both levels above each other, laid out as ``field.glsl`` says."""

    def __init__(self, context: moderngl.Context, field: IrradianceField) -> None:
        self._levels = field.levels
        sizes = np.array([level.weight.shape for level in field.levels])
        width, height = int(sizes[:, 0].max()), int(sizes[:, 1].max())
        volumes = [_volume(level, width, height) for level in field.levels]
        self._first = np.cumsum([0, *(len(volume) for volume in volumes)])[:-1]
        values = np.concatenate(volumes)
        self.texture = context.texture3d((width, height, len(values)), 4, values.tobytes(), dtype="f2")
        self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.probe = context.texture3d(field.probe.shape[::-1], 1, field.probe.astype(np.float16).tobytes(), dtype="f2")
        self.probe.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self.probe.repeat_x, self.probe.repeat_y, self.probe.repeat_z = True, False, False

    def uniforms(self, T_world_camera: Transform) -> dict[str, object]:
        """Return the uniforms of ``field.glsl`` for a view."""
        cells = []
        for level in self._levels:
            rows = T_world_camera[:3] / level.spacing[:, None]
            rows[:, 3] = (T_world_camera[:3, 3] - level.origin) / level.spacing
            cells.append(tuple(rows.T.ravel()))  # columns first
        return {
            "field_camera": cells,
            "field_size": [tuple(map(float, level.weight.shape)) for level in self._levels],
            "field_spacing": [tuple(level.spacing) for level in self._levels],
            "field_first": [float(first) for first in self._first],
            "field_fades": [tuple(side) for side in self._levels[0].cut.astype(float)],
            "world_camera": tuple(T_world_camera[:3, :3].T.ravel()),
        }


def _volume(level: FieldLevel, width: int, height: int) -> Float16[np.ndarray, "z y x 4"]:
    """Return the texels of one level: six blocks of irradiance, then the reach, in cells, up and down the axes."""
    nx, ny, nz = level.weight.shape
    values = np.zeros((8, nz, height, width, 4), np.float16)
    values[:6, :, :ny, :nx, :3] = np.minimum(level.irradiance.transpose(3, 2, 1, 0, 4), 6e4)
    reach = (level.reach.reshape(nx, ny, nz, 2, 3) / level.spacing).transpose(3, 2, 1, 0, 4)
    values[6:, :, :ny, :nx, :3] = reach
    values[6:, :, :ny, :nx, 3] = level.weight.transpose(2, 1, 0)
    return values.reshape(8 * nz, height, width, 4)


MAX_LIGHTS = 16
"""Lights that are shaded; of more, those that matter most to the view."""

# std140 layout of one element of the array ``lights`` in lights.glsl.
LIGHT = np.dtype(
    [
        ("position", "f4", 3),
        ("cone_offset", "f4"),
        ("axis", "f4", 3),
        ("cone_scale", "f4"),
        ("intensity", "f4", 3),
        ("texel_angle", "f4"),
        ("T_light_camera", "f4", (3, 4)),
        ("tile_scale", "f4", 2),
        ("tile_offset", "f4", 2),
        ("tile_low", "f4", 2),
        ("tile_high", "f4", 2),
        ("softness", "f4", 2),
        ("map_ramp", "f4", 2),
        ("along", "f4", 3),
        ("layer", "f4"),
    ]
)


@dataclass(frozen=True, eq=False)
class ShadedLight:
    """A light and its shadow map, if it has one."""

    light: Light
    tile: ShadowTile | None
    layer: int | None = None
    """Of its distribution in ``DistributionTexture``; None for a cone."""


def light_records(lights: Sequence[ShadedLight], T_world_camera: Transform) -> np.ndarray:
    """Return ``MAX_LIGHTS`` records of dtype ``LIGHT`` in the camera frame; unused ones are zero."""
    T_camera_world = invert(T_world_camera)
    records = np.zeros(MAX_LIGHTS, LIGHT)
    for record, item in zip(records, lights, strict=False):
        light = item.light
        record["position"] = transform_points(T_camera_world, np.asarray(light.position, float)[None])[0]
        record["intensity"] = light.intensity * np.asarray(light.color)
        # Falloff from the inner to the outer cone as in glTF's KHR_lights_punctual: saturate(cos * scale + offset)^2.
        record["cone_scale"], record["cone_offset"] = 0.0, 1.0
        if light.kind == "spot":
            inner, outer = np.cos(light.cone_inner), np.cos(light.cone_outer)
            record["axis"] = T_camera_world[:3, :3] @ np.asarray(light.direction, float)
            record["cone_scale"] = 1.0 / max(inner - outer, 1e-3)
            record["cone_offset"] = -outer * record["cone_scale"]
        record["map_ramp"] = map_ramp(light)
        record["layer"] = -1.0
        if item.layer is not None:
            record["along"] = T_camera_world[:3, :3] @ np.asarray(light.along)
            record["layer"] = item.layer
        if item.tile is not None:
            record["T_light_camera"] = (invert(item.tile.T_world_light) @ T_world_camera)[:3]
            record["tile_scale"], record["tile_offset"] = item.tile.scale, item.tile.offset
            record["tile_low"], record["tile_high"] = item.tile.low, item.tile.high
            record["texel_angle"] = item.tile.texel_angle
            record["softness"] = light.radius * ATLAS_PX / SHADOW_NEAR * np.array(item.tile.scale)
    return records


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
    "contact_map": 17,
    "probe": 18,
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
    contact: ContactMap
    """What is left of both where things stand on the floor."""
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
        return view | self.field.uniforms(T_world_camera) | self.contact.uniforms(T_world_camera)


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
        lighting.contact.texture.use(UNITS["contact_map"])
        lighting.field.probe.use(UNITS["probe"])
        if lighting.distributions is not None:
            lighting.distributions.texture.use(UNITS["distributions"])
