"""Textures as they are shipped: a folder of images for the colour, the normals and the roughness of a surface."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import UInt8

from warehouse_sim.errors import RenderError
from warehouse_sim.resources import texture_folder

NO_CHANGE = 128
"""Value of an albedo or roughness texture where it leaves the material's own as it is, and of a normal without tilt."""


@dataclass(frozen=True, eq=False)
class TextureImages:
    """The images of a texture set; row 0 is at v = 0."""

    albedo: UInt8[np.ndarray, "h w"]
    """What the base colour is multiplied by, in units of 1 / ``NO_CHANGE``."""
    normal: UInt8[np.ndarray, "h w 3"] | None
    """Unit normals; red along u, green up the image, which is against v."""
    roughness: UInt8[np.ndarray, "h w"] | None
    """What the roughness is multiplied by, in units of 1 / ``NO_CHANGE``."""


def read_texture_set(name: str) -> TextureImages:
    """Read a texture set's folder: ``albedo.png``, and ``normal.png`` and ``roughness.png`` where they exist.

    Raises:
        RenderError: The albedo is missing, or a file is no image.
    """
    folder = texture_folder(name)
    normal, roughness = folder / "normal.png", folder / "roughness.png"
    return TextureImages(
        albedo_factor(name),
        cv2.cvtColor(_read(name, normal, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB) if normal.is_file() else None,
        _read(name, roughness, cv2.IMREAD_GRAYSCALE) if roughness.is_file() else None,
    )


def albedo_factor(name: str) -> UInt8[np.ndarray, "h w"]:
    """Return the albedo of the texture called ``name`` alone.

    Raises:
        RenderError: The texture is not shipped, or is no image.
    """
    path = texture_folder(name) / "albedo.png"
    if not path.is_file():
        known = ", ".join(sorted(item.name for item in path.parent.parent.glob("*") if item.is_dir())) or "(none)"
        raise RenderError(f"texture {name!r}: {path} does not exist; textures there: {known}")
    return _read(name, path, cv2.IMREAD_GRAYSCALE)


def _read(name: str, path: Path, mode: int) -> np.ndarray:
    image = cv2.imread(str(path), mode)
    if image is None:
        raise RenderError(f"texture {name!r}: {path} is not a readable image; bake the assets again")
    return image
