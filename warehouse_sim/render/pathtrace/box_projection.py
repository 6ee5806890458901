"""Where a part's texture lies: the same tile coordinates as the raster backend's ``box_projection.glsl``.

Textures are laid on each face along the axis of the part that it looks at most, with u along the longest edge and v
along cross(normal, u), so that the same grain lies at the same place in both images.
"""

import numpy as np
from jaxtyping import Float, Int


def tile_coordinates(
    metres: Float[np.ndarray, "p f 3 3"], normals: Float[np.ndarray, "p f 3"], order: Int[np.ndarray, "p 3"]
) -> Float[np.ndarray, "p f 3 2"]:
    """Return how far along u and v (m) each corner lies.

    Args:
        metres: Corners of the faces of each part in the part's own frame (m).
        normals: Unit normals of the faces in that frame.
        order: Axes of each part from the longest edge to the shortest.
    """
    size = np.abs(normals)
    # As the shader compares: x wins ties, then y.
    facing = np.where(
        (size[..., 0] >= size[..., 1]) & (size[..., 0] >= size[..., 2]), 0, np.where(size[..., 1] >= size[..., 2], 1, 2)
    )
    u = np.where(order[:, None, 0] == facing, order[:, None, 1], order[:, None, 0])
    v = 3 - u - facing
    handed = np.where((u + 1) % 3 == v, 1.0, -1.0)
    towards = np.take_along_axis(normals, facing[..., None], axis=-1)[..., 0]
    along_u = np.take_along_axis(metres, u[..., None, None], axis=-1)[..., 0]
    along_v = np.take_along_axis(metres, v[..., None, None], axis=-1)[..., 0]
    return np.stack([along_u, along_v * np.where(towards < 0, -handed, handed)[..., None]], axis=-1)


def edge_order(extent: Float[np.ndarray, "p 3"]) -> Int[np.ndarray, "p 3"]:
    """Return the axes from the longest edge (m) to the shortest; edges equal to the centimetre keep x, y, z."""
    return np.argsort(-np.round(extent, 2), axis=1, kind="stable")


def texture_shift(instance_ids: Int[np.ndarray, " p"], numbers: Int[np.ndarray, " p"]) -> Float[np.ndarray, "p 2"]:
    """Return where in its tile each part starts: the R2 sequence (Roberts 2018) over object and part number."""
    return ((instance_ids * 131 + numbers)[:, None] * np.array([0.7548776662466927, 0.5698402909980532])) % 1.0
