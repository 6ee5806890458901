"""Triangles as a Mitsuba shape."""

from typing import Any

import mitsuba as mi
import numpy as np


def mesh_shape(corners: np.ndarray, texture: np.ndarray | None = None, surface: Any = None) -> Any:
    """Return a flat-shaded ``mi.Mesh``.

    Args:
        corners: World positions (m, 3, 3) of triangles, counter-clockwise seen from outside (m).
        texture: Texture coordinates (m, 3, 2) of the corners.
        surface: Its ``mi.BSDF``.
    """
    properties = mi.Properties()
    if surface is not None:
        properties["bsdf"] = surface
    count = 3 * len(corners)
    mesh = mi.Mesh("triangles", count, len(corners), props=properties, has_vertex_texcoords=texture is not None)
    values = mi.traverse(mesh)
    values["vertex_positions"] = np.ascontiguousarray(corners, np.float32).ravel()
    values["faces"] = np.arange(count, dtype=np.uint32)
    if texture is not None:
        values["vertex_texcoords"] = np.ascontiguousarray(texture, np.float32).ravel()
    values.update()
    return mesh
