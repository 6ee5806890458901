"""How a material looks to programs that multiply factors of at most one by textures of at most one.

Our textures are factors of up to two on a material's colour and roughness (``NO_CHANGE`` leaves them as they are).
Each becomes an image relative to a ceiling, and the ceiling goes into the material's factor. What would lift a colour
or a roughness above one is cut off there, as the path tracer does, and images are shared by the materials that agree
in the ceiling.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from warehouse_sim.color import srgb_from_linear
from warehouse_sim.errors import RenderError
from warehouse_sim.render.textures import NO_CHANGE, albedo_factor, picture_albedo
from warehouse_sim.resources import texture_folder
from warehouse_sim.schema import Material

_STEP = 4
"""Ceilings below the brightest texel are whole multiples of it (of 1 / ``NO_CHANGE``): up to 3 % of a bright texel."""


@dataclass(frozen=True)
class SurfaceImage:
    """One image of a surface by what it is made of; equal ones are the same image."""

    kind: Literal["albedo", "picture", "normal", "roughness"]
    source: str
    """Name of the texture set, or of the picture."""
    ceiling: int = NO_CHANGE
    """Code of the shipped file that is white in the image."""
    paper: tuple[float, float, float] | None = None
    """Linear colour behind a picture."""

    @property
    def repeats(self) -> bool:
        """Whether it is laid again and again; a picture is laid once."""
        return self.kind != "picture"


@dataclass(frozen=True)
class Surface:
    """Factors (0-1) and images of one material; without an image, a factor stands alone."""

    color: tuple[float, float, float]
    """Linear."""
    roughness: float
    metallic: float
    opacity: float
    emitted: tuple[float, float, float]
    """Luminance by channel (cd/m^2)."""
    albedo: SurfaceImage | None = None
    normal: SurfaceImage | None = None
    bumps: SurfaceImage | None = None
    """What the roughness is multiplied by."""


def surface_of(material: Material) -> Surface:
    """Return how ``material`` looks; under a picture its detail texture is left out, as all renderers do.

    Raises:
        RenderError: Its texture is not shipped.
    """
    red, green, blue = (float(np.clip(channel, 0.0, 1.0)) for channel in material.base_color)
    glow = red * material.emission, green * material.emission, blue * material.emission
    plain = Surface((red, green, blue), material.roughness, material.metallic, material.opacity, glow)
    if material.picture is not None:
        picture = SurfaceImage("picture", material.picture, paper=(red, green, blue))
        return Surface((1.0, 1.0, 1.0), plain.roughness, plain.metallic, plain.opacity, glow, albedo=picture)
    if material.texture is None:
        return plain
    name = material.texture
    top = _ceiling(int(albedo_factor(name).max()), max(red, green, blue))
    bright = top / NO_CHANGE
    rough = _optional(name, "roughness")
    peak = NO_CHANGE if rough is None else _ceiling(int(rough.max()), material.roughness)
    return Surface(
        (min(red * bright, 1.0), min(green * bright, 1.0), min(blue * bright, 1.0)),
        min(material.roughness * peak / NO_CHANGE, 1.0),
        material.metallic,
        material.opacity,
        glow,
        albedo=SurfaceImage("albedo", name, top),
        normal=None if _optional(name, "normal") is None else SurfaceImage("normal", name),
        bumps=None if rough is None else SurfaceImage("roughness", name, peak),
    )


def render_surface_image(image: SurfaceImage, material: Material) -> UInt8[np.ndarray, "h w *c"]:
    """Return the pixels of an image of ``material``, row 0 where v = 0.

    Colours are sRGB codes, grey where a texture has one channel. Roughness is linear. Normals are (n + 1) / 2 with
    green against v, as glTF and MuJoCo read them.
    """
    if image.kind == "picture":
        return _coded(picture_albedo(material))
    if image.kind == "normal":
        found = _optional(image.source, "normal")
        assert found is not None
        return np.ascontiguousarray(found[..., ::-1])
    if image.kind == "albedo":
        fraction = np.minimum(albedo_factor(image.source) / image.ceiling, 1.0)
        return _coded(fraction)
    found = _optional(image.source, "roughness")
    assert found is not None
    return np.rint(255.0 * np.minimum(found / image.ceiling, 1.0)).astype(np.uint8)


def encode_png(pixels: UInt8[np.ndarray, "h w *c"]) -> bytes:
    """Return a PNG file of grey or RGB pixels.

    Raises:
        RenderError: They cannot be encoded.
    """
    ok, data = cv2.imencode(".png", pixels if pixels.ndim == 2 else np.ascontiguousarray(pixels[..., ::-1]))
    if not ok:
        raise RenderError(f"an image of {pixels.shape} cannot be written as PNG; use 8-bit grey or RGB")
    return data.tobytes()


def _ceiling(brightest: int, value: float) -> int:
    """Return the largest code that, over ``NO_CHANGE``, keeps ``value`` times it at one or less."""
    if value * brightest <= NO_CHANGE:
        return max(brightest, 1)
    return max(int(NO_CHANGE / value) // _STEP * _STEP, NO_CHANGE)


def _coded(linear: Float[np.ndarray, "h w *c"]) -> UInt8[np.ndarray, "h w *c"]:
    return np.rint(255.0 * np.clip(srgb_from_linear(linear), 0.0, 1.0)).astype(np.uint8)


@lru_cache(maxsize=16)
def _optional(name: str, kind: Literal["normal", "roughness"]) -> UInt8[np.ndarray, "h w *c"] | None:
    """Return an image of a texture set as OpenCV reads it, None where the set has none.

    Raises:
        RenderError: It is no image.
    """
    path = texture_folder(name) / f"{kind}.png"
    if not path.is_file():
        return None
    image = cv2.imread(str(path), cv2.IMREAD_COLOR if kind == "normal" else cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise RenderError(f"texture {name!r}: {path} is not a readable image; bake the assets again")
    return np.asarray(image, np.uint8)
