"""The lights of a scene as the shading pass reads them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.render.light_selection import map_ramp
from warehouse_sim.render.raster.light.shadows import ATLAS_PX, SHADOW_NEAR, ShadowTile
from warehouse_sim.schema import Light

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
