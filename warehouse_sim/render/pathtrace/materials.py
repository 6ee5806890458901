"""Materials as scattering functions: metallic-roughness by Mitsuba's ``principled``, textured and bent by normal maps.

``principled`` is Burley's model ("Physically based shading at Disney", 2012): a diffuse part with retro-reflection
under a GGX lobe of 4 % at normal incidence, or a tinted GGX lobe for metals.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import cv2
import mitsuba as mi
import numpy as np
from jaxtyping import Float32

from warehouse_sim.render.textures import NO_CHANGE, picture_albedo, read_texture_set
from warehouse_sim.schema import Material

_ALBEDO_PX = 512
"""Largest edge: each painted material has a map of its own, and a hall some hundred of them."""


@dataclass(frozen=True, eq=False)
class TextureSet:
    """How a texture changes the surface that it lies on; each (height, width, channels), row 0 at v = 0."""

    albedo: Float32[np.ndarray, "h w 1"]
    """Factor on the base colour."""
    normal: Float32[np.ndarray, "h w 3"] | None
    """Unit normals along u, v and out of the surface, stored as (n + 1) / 2."""
    roughness: Float32[np.ndarray, "h w 1"] | None
    """Factor on the roughness."""


@lru_cache(maxsize=64)
def load_texture_set(name: str) -> TextureSet:
    """Return the texture set called ``name`` as factors and unit normals.

    Raises:
        RenderError: The albedo is missing, or a file is no image.
    """
    images = read_texture_set(name)
    albedo = images.albedo
    if albedo.shape[0] > _ALBEDO_PX:
        albedo = cv2.resize(albedo, (_ALBEDO_PX, _ALBEDO_PX), interpolation=cv2.INTER_AREA)
    return TextureSet(
        albedo=_factor(albedo),
        normal=None if images.normal is None else _normal(images.normal),
        roughness=None if images.roughness is None else _factor(images.roughness),
    )


def _factor(codes: np.ndarray) -> np.ndarray:
    return (codes[..., None] / np.float32(NO_CHANGE)).astype(np.float32)


def _normal(codes: np.ndarray) -> np.ndarray:
    """Return normals from their codes (red along u, green up the image, which is against v)."""
    bend = (codes[..., :2].astype(np.float32) - NO_CHANGE) / 127.0 * [1.0, -1.0]
    out = np.sqrt(np.maximum(1.0 - (bend**2).sum(axis=-1, keepdims=True), 0.0))
    return (np.concatenate([bend, out], axis=-1).astype(np.float32) + 1.0) / 2.0


_MIN_ROUGHNESS = 0.05  # as the raster backend has it
_ROUGHNESS_STEP = 0.02
"""Roughness of textured materials is rounded to it, so that they share their maps."""


def scattering(material: Material) -> Any:
    """Return the ``mi.BSDF`` of ``material``, the same from both sides.

    Raises:
        RenderError: Its texture is not shipped.
    """
    return _surface(material, np.clip(material.base_color, 0.0, 1.0))


def gloss(material: Material) -> Any:
    """Return the ``mi.BSDF`` of what a clear film of ``material`` mirrors: its scattering without the diffuse part."""
    return _surface(material, np.zeros(3))


def albedo_factor(material: Material) -> Any:
    """Return the ``mi.Texture`` that a textured material's base colour is multiplied by, or None."""
    return None if material.texture is None else _bitmap(load_texture_set(material.texture).albedo)


def _surface(material: Material, base: np.ndarray) -> Any:
    textured = material.texture is not None and material.picture is None
    texture = load_texture_set(str(material.texture)) if textured else None
    surface: dict[str, Any] = {
        "type": "principled",
        "base_color": {"type": "rgb", "value": base.tolist()},
        "roughness": max(material.roughness, _MIN_ROUGHNESS),
        "metallic": material.metallic,
        "specular": 0.5,  # reflects 4 % at normal incidence
    }
    if material.picture is not None and base.any():
        surface["base_color"] = _bitmap(picture_albedo(material))
    if texture is not None and base.any():
        surface["base_color"] = _bitmap(np.clip(texture.albedo * base, 0.0, 1.0))
    if texture is not None and texture.roughness is not None:
        step = round(material.roughness / _ROUGHNESS_STEP)
        surface["roughness"] = _roughness(texture, step, mi.variant())
    if texture is not None and texture.normal is not None:
        bent = _normals(texture, mi.variant())
        surface = {"type": "normalmap", "normalmap": bent, "surface": surface}
    return mi.load_dict({"type": "twosided", "surface": surface})


# A hall has some hundred painted materials on a dozen texture sets: what only the set decides is made once.
@lru_cache(maxsize=64)
def _normals(texture: TextureSet, variant: str) -> Any:
    assert texture.normal is not None
    return _bitmap(texture.normal)


@lru_cache(maxsize=256)
def _roughness(texture: TextureSet, step: int, variant: str) -> Any:
    assert texture.roughness is not None
    return _bitmap(np.clip(texture.roughness * (step * _ROUGHNESS_STEP), _MIN_ROUGHNESS, 1.0))


def _bitmap(values: np.ndarray) -> Any:
    bitmap = mi.Bitmap(np.ascontiguousarray(values, np.float32))
    # Raw: the values are linear already.
    return mi.load_dict({"type": "bitmap", "bitmap": bitmap, "raw": True, "wrap_mode": "repeat", "format": "fp16"})
