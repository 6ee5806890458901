"""Textures that make a base colour uneven, as they are shipped."""

import cv2
import numpy as np
from jaxtyping import UInt8

from warehouse_sim.errors import RenderError
from warehouse_sim.resources import texture_folder

NO_CHANGE = 128
"""Value of an albedo texture where it leaves the material's colour as it is."""


def albedo_factor(name: str) -> UInt8[np.ndarray, "h w"]:
    """Return the texture called ``name``: what the base colour is multiplied by, in units of 1 / ``NO_CHANGE``.

    Raises:
        RenderError: The texture is not shipped, or is no image.
    """
    path = texture_folder(name) / "albedo.png"
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) if path.is_file() else None
    if image is None:
        raise RenderError(f"texture {name!r}: {path} is missing or no image; bake the assets again")
    return image
