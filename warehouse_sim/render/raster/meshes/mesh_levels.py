"""The levels of detail of a mesh, and which of them a view needs."""

from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.detail_levels import detail_levels
from warehouse_sim.geometry.facets import facets
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.render.raster.meshes.face_edges import FlatMesh, flat_mesh
from warehouse_sim.render.raster.meshes.parts import PartTable
from warehouse_sim.render.raster.projection import NEAR

LEVEL_ERROR_PX = 0.25
"""How far a coarser mesh may be from the true one in the image."""


@dataclass(frozen=True, eq=False)
class MeshLevels:
    """A mesh as the rasteriser reads it, at all its levels of detail."""

    flat: tuple[FlatMesh, ...]
    """The finest first."""
    errors: Float[np.ndarray, " l"]
    """Largest distance of each from the true surface, in the mesh's own units (m)."""


_known: WeakKeyDictionary[TriangleMesh, MeshLevels] = WeakKeyDictionary()


def mesh_levels(mesh: TriangleMesh) -> MeshLevels:
    """Return the levels of ``mesh``, made when first requested and kept as long as the mesh is."""
    if mesh not in _known:
        found = facets(mesh)
        finest, *coarser = detail_levels(mesh, found)
        flat = (flat_mesh(finest.mesh, found), *(flat_mesh(level.mesh) for level in coarser))
        _known[mesh] = MeshLevels(flat, np.array([finest.error, *(level.error for level in coarser)]))
    return _known[mesh]


def only_level(mesh: TriangleMesh) -> MeshLevels:
    """Return ``mesh`` as it is rendered at any distance."""
    return MeshLevels((flat_mesh(mesh),), np.zeros(1))


def choose_levels(
    table: PartTable, errors: Sequence[Float[np.ndarray, " l"]], records: np.ndarray, camera: PinholeCamera
) -> Int[np.ndarray, " n"]:
    """Return the coarsest level of each row of ``table`` whose error nobody sees; it depends on the row and view alone.

    Args:
        table: The parts.
        errors: For each mesh of the table, the errors of its levels.
        records: The table placed in the camera frame.
        camera: Intrinsics.
    """
    levels = np.zeros(len(table), int)
    detailed = [(rows, limits) for rows, limits in zip(table.rows_of_mesh, errors, strict=True) if len(limits) > 1]
    if not detailed:
        return levels
    # Along the axis only: an upright is tall, but all of it is about as far away.
    reach = (np.abs(records["rotation"][:, :, 2]) * table.half_size).sum(axis=1)
    nearest = np.maximum(table.centres(records)[:, 2] - reach, NEAR)
    # At the border of a wide image a shift along the axis is seen more than at its middle.
    across = max(camera.cx, camera.width - camera.cx) / camera.fx
    down = max(camera.cy, camera.height - camera.cy) / camera.fy
    pixels_per_metre = max(camera.fx, camera.fy) * np.sqrt(1.0 + across**2 + down**2) / nearest
    allowed = LEVEL_ERROR_PX / (pixels_per_metre * np.abs(table.template["scale"]).max(axis=1))
    for rows, limits in detailed:
        levels[rows] = np.searchsorted(limits, allowed[rows], side="right") - 1
    return levels
