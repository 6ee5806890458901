"""Materials and lights of a scene for fixed-function shading, which adds up display values instead of light.

There is no exposure and no tone curve behind it, so both are put into the colours. At the reference illuminance, that
of surfaces before the viewpoints that face the lights, a material has the colour that the display transform gives it
there, and all lights and the even light together add up to one. Below it, display values follow the square root of
light, close to what sRGB does of it: a light's share falls with the distance, not with its square.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from jaxtyping import Float64, UInt8

from warehouse_sim.render.display import to_display
from warehouse_sim.render.light_selection import GROUND, even_illuminance, facing_illuminance, reference_points
from warehouse_sim.render.texture_layout import picture_albedo
from warehouse_sim.render.texture_set import NO_CHANGE, albedo_factor
from warehouse_sim.schema import Light, Material, SceneSpec

_TYPICAL_COSINE = 0.4
"""Of the incidence at which OpenGL's shading by the cosine meets the square root of light that displays show."""


@dataclass(frozen=True, eq=False)
class Level:
    """How a scene's light is turned into display values."""

    white: float
    """Linear image value of a white surface at the reference illuminance."""
    even: float
    """Display value of the even light, 0-1."""
    lights: Float64[np.ndarray, " n"]
    """Display value of each light on its axis at a metre's distance."""


def measure_level(scene: SceneSpec, lights: list[Light]) -> Level:
    """Return the level of ``scene`` under ``lights``."""
    even, points = even_illuminance(scene), reference_points(scene)
    lit = np.array([facing_illuminance(light, points) for light in lights]).reshape(len(lights), len(points))
    total = even + float(lit.sum(axis=0).mean()) if lights else even
    roots = float(np.sqrt(lit).sum(axis=0).mean()) if lights else 0.0
    even_level = float(np.sqrt(even / total)) if total > 0 else 1.0
    scale = (1.0 - even_level) / (np.sqrt(_TYPICAL_COSINE) * roots) if roots > 0 else 0.0
    white = scene.exposure * total / np.pi
    return Level(white, even_level, scale * np.sqrt([light.intensity for light in lights]))


def add_background(spec: mujoco.MjSpec, scene: SceneSpec) -> None:
    """Fill the image where nothing stands with the lower half of the even light."""
    linear = scene.ambient / np.pi * GROUND * scene.exposure
    color = to_display(np.full((1, 1, 3), linear))[0, 0] / 255.0
    kind, fill = mujoco.mjtTexture.mjTEXTURE_SKYBOX, mujoco.mjtBuiltin.mjBUILTIN_FLAT
    spec.add_texture(name="background", type=kind, builtin=fill, rgb1=color, rgb2=color, width=8, height=48)


def add_material(spec: mujoco.MjSpec, name: str, material: Material, white: float, exposure: float) -> None:
    """Add ``material``; a texture set contributes its albedo, and is added when it is first named.

    Blinn's exponent for a GGX lobe of width a is 2 / a^2 - 2 (Karis 2013), its peak (exponent + 8) / 8 * F0.
    """
    base = np.array(material.base_color)
    brightest, texture = 1.0, None
    if material.texture is not None:
        brightest = albedo_factor(material.texture).max() / NO_CHANGE
        texture = _texture(spec, material.texture)
    if material.picture is not None:
        base, brightest = np.ones(3), 1.0
        texture = _picture(spec, name, to_display(picture_albedo(material) * white))
    shown = np.full(3, 1.0) if material.picture else to_display((base * brightest * white)[None, None])[0, 0] / 255.0
    glow = to_display((base * material.emission * exposure)[None, None])[0, 0] / 255.0
    exponent = 2.0 / max(material.roughness, 0.1) ** 4 - 2.0
    f0 = float(np.mean(0.04 * (1.0 - material.metallic) + base * material.metallic))
    item = spec.add_material(
        name=name,
        rgba=[*(glow if material.emission > 0 else shown), material.opacity],
        emission=1.0 if material.emission > 0 else 0.0,
        specular=min((exponent + 8.0) / 8.0 * f0, 1.0),
        shininess=float(np.clip(exponent / 128.0, 0.0, 1.0)),
    )
    if texture is not None:
        names = [""] * mujoco.mjtTextureRole.mjNTEXROLE
        names[mujoco.mjtTextureRole.mjTEXROLE_RGB] = texture
        item.textures = names


def add_light(spec: mujoco.MjSpec, light: Light, level: float, casts_shadow: bool) -> None:
    """Add ``light`` with ``level``, its display value on the axis at a metre's distance.

    A point light is a spot whose cone is a half space: MuJoCo draws no point lights. The falloff of the cone is met
    where it is half.
    """
    inner, outer = (light.cone_inner, light.cone_outer) if light.kind == "spot" else (1.5, 1.57)
    half = 0.5 * (np.cos(inner) + np.cos(outer))
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_SPOT,
        pos=light.position,
        dir=light.direction if light.kind == "spot" else (0.0, 0.0, -1.0),
        diffuse=level * np.array(light.color),
        specular=level * np.array(light.color),
        ambient=(0.0, 0.0, 0.0),
        attenuation=(0.0, 1.0, 0.0),
        cutoff=min(np.degrees(outer), 90.0),
        exponent=float(np.log(0.5) / np.log(max(half, 1e-3))),
        castshadow=casts_shadow,
    )


def _texture(spec: mujoco.MjSpec, name: str) -> str:
    if all(item.name != name for item in spec.textures):
        image = _display_factor(albedo_factor(name))
        item = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D)
        item.height, item.width, item.nchannel = (*image.shape[:2], 3)
        item.data = image.tobytes()
    return name


def _picture(spec: mujoco.MjSpec, name: str, shown: UInt8[np.ndarray, "h w 3"]) -> str:
    """Add the texture of one material's picture in display values."""
    item = spec.add_texture(name=f"{name}/picture", type=mujoco.mjtTexture.mjTEXTURE_2D)
    item.height, item.width, item.nchannel = (*shown.shape[:2], 3)
    item.data = shown.tobytes()
    return f"{name}/picture"


def _display_factor(factor: UInt8[np.ndarray, "h w"]) -> UInt8[np.ndarray, "h w 3"]:
    """Return what a factor on the albedo, relative to the largest, does to a display value."""
    relative = np.sqrt(factor / max(int(factor.max()), 1))
    return np.repeat(np.rint(255.0 * relative).astype(np.uint8)[..., None], 3, axis=2)
