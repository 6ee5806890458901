"""Pictures for backends that know textures only: where they lie, and their colour with the material's own behind it.

Both are those of the raster backend's ``picture.vert.glsl``; under a picture the detail texture is left out.
"""

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.catalog.pictures import draw_picture
from warehouse_sim.color import linear_from_srgb
from warehouse_sim.schema import Material

_CORNER = 0.003
"""Place in the picture that faces without one show: paper, or bare board."""


def picture_coordinates(
    metres: Float[np.ndarray, "*c 3"], normals: Float[np.ndarray, "*c 3"]
) -> Float[np.ndarray, "*c 2"]:
    """Return u to the right and v downwards, 0-1 over the largest faces of one part, of each corner.

    Args:
        metres: Corners in the part's own frame (m).
        normals: Unit normals of their faces there.
    """
    flat = metres.reshape(-1, 3)
    low, extent = flat.min(axis=0), np.ptp(flat, axis=0)
    facing = int(np.argmin(extent))
    up = 1 if facing == 2 else 2
    across = 3 - facing - up
    at = (metres - low) / np.maximum(extent, 1e-6)
    mirrored = (normals[..., facing] < 0.0) != (facing == 1)
    laid = np.stack([np.where(mirrored, 1.0 - at[..., across], at[..., across]), 1.0 - at[..., up]], axis=-1)
    return np.where((np.abs(normals[..., facing]) > 0.7)[..., None], laid, _CORNER)


def picture_albedo(material: Material) -> Float32[np.ndarray, "h w 3"]:
    """Return the linear albedo of ``material`` under its picture; row 0 is the picture's upper edge.

    Raises:
        ValueError: It has no picture.
    """
    if material.picture is None:
        raise ValueError(f"material {material.name!r} has no picture")
    image = draw_picture(material.picture)
    cover = image[..., 3:].astype(np.float32) / 255.0
    ink = linear_from_srgb(image[..., :3] / 255.0).astype(np.float32)
    return np.array(material.base_color, np.float32) * (1.0 - cover) + ink * cover
