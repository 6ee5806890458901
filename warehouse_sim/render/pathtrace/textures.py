"""The baked texture sets as arrays that scattering functions are made of."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float32

from warehouse_sim.errors import RenderError
from warehouse_sim.render.albedo import NO_CHANGE
from warehouse_sim.resources import texture_folder

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
    """Read a texture set's folder: ``albedo.png``, and ``normal.png`` and ``roughness.png`` where they exist.

    Raises:
        RenderError: The albedo is missing, or a file is no image.
    """
    folder = texture_folder(name)
    if not (folder / "albedo.png").is_file():
        known = ", ".join(sorted(item.name for item in folder.parent.glob("*") if item.is_dir())) or "(none)"
        raise RenderError(f"texture {name!r}: {folder / 'albedo.png'} does not exist; textures there: {known}")
    albedo = _read(name, folder / "albedo.png", cv2.IMREAD_GRAYSCALE)
    if albedo.shape[0] > _ALBEDO_PX:
        albedo = cv2.resize(albedo, (_ALBEDO_PX, _ALBEDO_PX), interpolation=cv2.INTER_AREA)
    normal = _read(name, folder / "normal.png", cv2.IMREAD_COLOR) if (folder / "normal.png").is_file() else None
    roughness = folder / "roughness.png"
    return TextureSet(
        albedo=_factor(albedo),
        normal=None if normal is None else _normal(normal[..., ::-1]),
        roughness=_factor(_read(name, roughness, cv2.IMREAD_GRAYSCALE)) if roughness.is_file() else None,
    )


def _factor(codes: np.ndarray) -> np.ndarray:
    return (codes[..., None] / np.float32(NO_CHANGE)).astype(np.float32)


def _normal(codes: np.ndarray) -> np.ndarray:
    """Return normals from their codes (red along u, green up the image, which is against v)."""
    bend = (codes[..., :2].astype(np.float32) - NO_CHANGE) / 127.0 * [1.0, -1.0]
    out = np.sqrt(np.maximum(1.0 - (bend**2).sum(axis=-1, keepdims=True), 0.0))
    return (np.concatenate([bend, out], axis=-1).astype(np.float32) + 1.0) / 2.0


def _read(name: str, path: Path, mode: int) -> np.ndarray:
    image = cv2.imread(str(path), mode)
    if image is None:
        raise RenderError(f"texture {name!r}: {path} is not a readable image; bake the assets again")
    return image
