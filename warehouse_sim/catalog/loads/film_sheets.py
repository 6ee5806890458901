"""Sheets of film between two lines on the skin around a load, laid on it all at once: a load has hundreds of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.catalog.loads.film_skin import FilmSkin
from warehouse_sim.geometry.mesh import TriangleMesh


@dataclass(frozen=True, eq=False)
class Sheet:
    """What lies between a lower (or left) line and an upper (or right) one, point by point."""

    column: Float[np.ndarray, "2 n"]
    """Columns of the points of both lines."""
    height: Float[np.ndarray, "2 n"]
    """Heights of them (m)."""
    proud: float = 0.0
    """How far the sheet stands over the skin (m)."""
    wide: Bool[np.ndarray, " n"] | None = None
    """Where the lines are apart; what lies between two places that are not wide is left out. None: everywhere."""


def laid_on(skin: FilmSkin, sheets: Mapping[str, Sequence[Sheet]]) -> dict[str, TriangleMesh]:
    """Return one mesh for each material of ``sheets``: the sheets after one another, each with its lower line first."""
    every = [sheet for group in sheets.values() for sheet in group]
    proud = np.repeat([sheet.proud for sheet in every], [sheet.column.size for sheet in every])
    points = skin.points(
        np.concatenate([sheet.column.ravel() for sheet in every]),
        np.concatenate([sheet.height.ravel() for sheet in every]),
        proud,
    )
    found, first = dict[str, TriangleMesh](), 0
    for material, group in sheets.items():
        starts = np.cumsum([0, *(sheet.column.size for sheet in group)])
        faces = [band_faces(sheet.column.shape[1], sheet.wide) + at for sheet, at in zip(group, starts, strict=False)]
        vertices = points[first : first + starts[-1]]
        found[material] = TriangleMesh(vertices, np.concatenate([np.empty((0, 3), int), *faces]).astype(np.int32))
        first += int(starts[-1])
    return found


def band_faces(count: int, wide: Bool[np.ndarray, " n"] | None = None) -> Int[np.ndarray, "m 3"]:
    """Return the faces of a sheet whose lines have ``count`` points, but for those between two not ``wide`` ones."""
    keep = np.ones(count - 1, bool) if wide is None else wide[:-1] | wide[1:]
    i = np.arange(count - 1, dtype=np.int32)[keep]
    return np.concatenate([np.stack([i, i + 1, i + 1 + count], -1), np.stack([i, i + 1 + count, i + count], -1)])
