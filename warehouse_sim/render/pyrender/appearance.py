"""Materials and lights for pyrender, which adds up light linearly, but returns it clipped and without a tone curve.

The scene is rendered ``HEADROOM`` times darker than its exposure says, so that nothing below that many times white is
clipped, and the bytes that come back are brought to the display's curve by a table.
"""

from typing import Any

import numpy as np
from jaxtyping import UInt8

from warehouse_sim.color import srgb_from_linear
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.render.display import to_display
from warehouse_sim.render.light_selection import GROUND, even_illuminance
from warehouse_sim.render.pyrender.device import import_pyrender
from warehouse_sim.render.textures import NO_CHANGE, albedo_factor, picture_albedo
from warehouse_sim.scene.lighting.photometry import as_cone
from warehouse_sim.schema import Light, Material, SceneSpec

HEADROOM = 4.0
"""Linear image value that pyrender's white stands for."""
_GAMMA = 2.2  # pyrender returns light to the power 1 / 2.2


class MaterialCache:
    """pyrender's materials of a scene, made when they are first requested; textures are shared."""

    def __init__(self, materials: dict[str, Material], exposure: float) -> None:
        self._materials, self._exposure = materials, exposure
        self._made: dict[str, Any] = {}
        self._textures: dict[str, tuple[Any, float]] = {}

    def __getitem__(self, name: str) -> Any:
        """Return the material called ``name``."""
        if name not in self._made:
            self._made[name] = self._make(self._materials[name])
        return self._made[name]

    def _make(self, material: Material) -> Any:
        texture, brightest = None, 1.0
        if material.texture is not None:
            if material.texture not in self._textures:
                self._textures[material.texture] = _texture(albedo_factor(material.texture))
            texture, brightest = self._textures[material.texture]
        base = np.array(material.base_color)
        if material.picture is not None:
            code = np.rint(255.0 * srgb_from_linear(picture_albedo(material))).astype(np.uint8)
            texture = import_pyrender().Texture(source=code[::-1], source_channels="RGB")
            base, brightest = np.ones(3), 1.0
        glow = base * material.emission * self._exposure / HEADROOM
        return import_pyrender().MetallicRoughnessMaterial(
            baseColorFactor=np.append(np.clip(base * brightest, 0.0, 1.0), 1.0),
            baseColorTexture=texture,
            metallicFactor=material.metallic,
            roughnessFactor=material.roughness,
            emissiveFactor=np.sqrt(np.clip(glow, 0.0, 1.0)),  # its shader multiplies the factor by itself
        )


def ambient_light(scene: SceneSpec) -> list[float]:
    """Return pyrender's even light, which knows no direction, for a white surface."""
    return [even_illuminance(scene) / np.pi * scene.exposure / HEADROOM] * 3


def background(scene: SceneSpec) -> list[float]:
    """Return the lower half of the even light, as pyrender writes it into the image."""
    linear = scene.ambient / np.pi * GROUND * scene.exposure / HEADROOM
    return [*([min(linear, 1.0) ** (1.0 / _GAMMA)] * 3), 1.0]


def make_light(light: Light, exposure: float) -> tuple[Any, Transform]:
    """Return pyrender's light, whose cone falls off as ours does, and its pose: it shines along its own -z."""
    light = as_cone(light)
    pyrender, intensity = import_pyrender(), light.intensity * exposure / HEADROOM
    color, T = np.array(light.color), make_transform(None, np.asarray(light.position, float))
    peak = float(color.max())  # pyrender clips colours at 1
    if light.kind == "point":
        return pyrender.PointLight(color=color / peak, intensity=intensity * peak), T
    back = -np.asarray(light.direction, float)
    side = np.cross(back, np.eye(3)[np.abs(back).argmin()])
    side /= np.linalg.norm(side)
    T[:3, :3] = np.stack([side, np.cross(back, side), back], axis=1)
    cone = {"innerConeAngle": light.cone_inner, "outerConeAngle": light.cone_outer}
    return pyrender.SpotLight(color=color / peak, intensity=intensity * peak, **cone), T


def display_table() -> UInt8[np.ndarray, "256"]:
    """Return what a display shows of each byte that pyrender returns."""
    linear = HEADROOM * (np.arange(256) / 255.0) ** _GAMMA
    return to_display(np.repeat(linear[None, :, None], 3, axis=2))[0, :, 0]


def _texture(factor: UInt8[np.ndarray, "h w"]) -> tuple[Any, float]:
    """Return the texture, relative to its brightest texel, and that texel's factor; pyrender reads it as sRGB."""
    brightest = int(factor.max())
    code = srgb_from_linear(np.arange(256) / brightest)
    pixels = np.rint(255.0 * np.clip(code, 0.0, 1.0)).astype(np.uint8)[factor]
    # pyrender turns images upside down: v of a tile grows with its rows.
    source = np.repeat(pixels[::-1, :, None], 3, axis=2)
    return import_pyrender().Texture(source=source, source_channels="RGB"), brightest / NO_CHANGE
