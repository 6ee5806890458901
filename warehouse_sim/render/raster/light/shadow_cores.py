"""Cladding and the like in the shadow maps: thinner than it is, so that its ribs do not shade it."""

import numpy as np
from jaxtyping import Int

from warehouse_sim.render.raster.meshes.parts import PartTable

_WIDE = 1.0
"""A sheet reaches at least so far from its middle in both directions (m)."""
_THIN = 0.15
"""And at most so far across (m)."""
_MANY_FACES = 64
"""Sheets of more faces have relief."""
_CORE = 0.3
"""Fraction of a sheet's thickness that casts its shadow."""


def thinned_sheets(table: PartTable, records: np.ndarray) -> np.ndarray:
    """Return ``records`` with wide sheets that have relief thinned to their core.

    The ribs of a wall are finer than the texels of a map that shows a hall, so their shadows on the wall would be
    patterns of the two grids. The core lies inside of the sheet, below the feet of its ribs: it shades all that the
    sheet does, to a few centimetres, but not the sheet.

    Args:
        table: The parts.
        records: The table placed in some frame.
    """
    rows = _relief_rows(table)
    if len(rows) == 0:
        return records
    axis = table.half_size[rows].argmin(axis=1)
    thinned = records.copy()
    thinned["scale"][rows, axis] *= _CORE
    # About the sheet's middle; the rotation is stored by its columns.
    shift = (1.0 - _CORE) * table.local_centre[rows, axis]
    thinned["translation"][rows] += records["rotation"][rows, axis] * shift[:, None].astype(np.float32)
    return thinned


def _relief_rows(table: PartTable) -> Int[np.ndarray, " k"]:
    """Return the rows of wide sheets with relief."""
    faces = np.zeros(len(table), int)
    for rows, mesh in zip(table.rows_of_mesh, table.meshes, strict=True):
        faces[rows] = len(mesh.faces)
    thinnest, middle, _ = np.sort(table.half_size, axis=1).T
    return np.flatnonzero((thinnest < _THIN) & (middle > _WIDE) & (faces > _MANY_FACES))
