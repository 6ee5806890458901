"""What a hall looks like in all directions from its middle, as rough surfaces mirror it: walls, racks, roof and floor.

The grid of irradiance knows six directions a point; this knows how light differs from one direction to the next, as a
factor on what the grid says. Lamps are left out: shading mirrors each by itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.color import LUMINANCE
from warehouse_sim.render.light_grid import GridLevel, LightGrid
from warehouse_sim.render.light_selection import GROUND, direct_irradiance
from warehouse_sim.schema import Light

COLUMNS, ROWS = 48, 24
"""Directions around and from zenith to nadir; the first column looks along x."""
ROUGHNESS = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Perceptual roughness of the levels."""
_EYE = 2.0
"""Height that the probe is near to (m)."""
_BOUNDS = (0.25, 3.0)
"""Of the factor: the probe stands for all of a hall, and no place of it shall be far off."""


def hall_probe(
    grid: LightGrid,
    irradiance: Sequence[Float32[np.ndarray, "nx ny nz 6 3"]],
    lights: Sequence[Light],
    ambient: float,
) -> Float32[np.ndarray, "levels rows columns"]:
    """Return luminance that surfaces of ``ROUGHNESS`` mirror over the cosine-weighted mean about its direction.

    Args:
        grid: That of the scene.
        irradiance: Of each of its levels.
        lights: Of the scene.
        ambient: Illuminance (lx) of an even sky on an upward surface.
    """
    directions, lobes = _lobes()
    hits = grid.solid.cast(np.repeat(_middle(grid.levels[0])[None], len(directions), axis=0), directions)
    met = np.flatnonzero(np.isfinite(hits.distance))
    normals = hits.normals[met]
    places = _middle(grid.levels[0]) + hits.distance[met, None] * directions[met] + 1e-3 * normals
    arriving = direct_irradiance(grid.solid, lights, places, normals, {}) + _indirect(grid, irradiance, places, normals)
    luminance = np.where(directions[:, 2] >= 0.0, 1.0, GROUND) * np.float32(ambient / np.pi)
    luminance[met] = (hits.albedo[met] * arriving) @ LUMINANCE.astype(np.float32) / np.float32(np.pi)
    even, *blurred = (lobe.mean(luminance) for lobe in lobes)
    even = np.maximum(even, np.float32(1e-6))
    factor = np.clip(np.maximum(np.array(blurred), 1e-6) / even, *_BOUNDS)
    return factor.reshape(len(ROUGHNESS), ROWS, COLUMNS).astype(np.float32)


@dataclass(frozen=True, eq=False)
class _Lobe:
    """How much each direction counts about each of them."""

    weights: Float32[np.ndarray, "n n"]
    area: Float32[np.ndarray, " n"]
    """Solid angle that a direction stands for, up to a factor."""
    total: Float32[np.ndarray, " n"]

    @classmethod
    def of(cls, weights: Float32[np.ndarray, "n n"], area: Float32[np.ndarray, " n"]) -> "_Lobe":
        return cls(weights, area, weights @ area)

    def mean(self, luminance: Float32[np.ndarray, " n"]) -> Float32[np.ndarray, " n"]:
        """Return the mean of what comes from each direction, about each direction."""
        return (self.weights @ (self.area * luminance)) / self.total


@cache
def _lobes() -> tuple[Float32[np.ndarray, "n 3"], list[_Lobe]]:
    """Return the directions, and the lobes of the cosine and of ``ROUGHNESS``; no scene changes them."""
    directions, area = _directions()
    cosine = np.maximum(directions @ directions.T, 0.0)
    return directions, [_Lobe.of(cosine, area), *(_Lobe.of(_ggx(cosine, roughness), area) for roughness in ROUGHNESS)]


def _directions() -> tuple[Float32[np.ndarray, "n 3"], Float32[np.ndarray, " n"]]:
    """Return unit directions row by row, and the solid angle that each stands for, up to a factor."""
    polar, around = np.pi * (np.arange(ROWS) + 0.5) / ROWS, 2 * np.pi * (np.arange(COLUMNS) + 0.5) / COLUMNS
    polar, around = (grid.ravel() for grid in np.meshgrid(polar, around, indexing="ij"))
    flat = np.sin(polar)
    directions = np.stack([flat * np.cos(around), flat * np.sin(around), np.cos(polar)], axis=1)
    return directions.astype(np.float32), flat.astype(np.float32)


def _middle(level: GridLevel) -> Float[np.ndarray, "3"]:
    """Return the point in the open that is nearest to the middle of the fine grid, at the height of eyes."""
    points = level.points
    middle = np.append((points.min(axis=0) + points.max(axis=0))[:2] / 2, _EYE)
    away = np.square(points - middle).sum(axis=1)
    return np.asarray(points[np.argmin(np.where(level.trusted.ravel(), away, np.inf))])


def _indirect(
    grid: LightGrid,
    irradiance: Sequence[Float32[np.ndarray, "nx ny nz 6 3"]],
    places: Float[np.ndarray, "n 3"],
    normals: Float32[np.ndarray, "n 3"],
) -> Float32[np.ndarray, "n 3"]:
    """Return the irradiance (lx) by the surroundings of surfaces, from the point of the coarse grid before each."""
    level = grid.levels[-1]
    cells = np.clip(level.cells(places + 0.5 * level.spacing * normals), 0, np.array(level.shape) - 1)
    cubes = irradiance[-1][tuple(cells.T)]
    sides = np.where(normals >= 0.0, [0, 1, 2], [3, 4, 5])
    return sum(np.square(normals[:, axis, None]) * cubes[np.arange(len(cubes)), sides[:, axis]] for axis in range(3))


def _ggx(cosine: Float32[np.ndarray, "n n"], roughness: float) -> Float32[np.ndarray, "n n"]:
    """Return the weights of directions about a mirrored one: GGX of the half vector, times the cosine.

    Seen along the normal, after Karis 2013, "Real shading in Unreal Engine 4".
    """
    squared = roughness**4
    half = (1.0 + cosine) / 2.0
    return cosine / np.square(half * (squared - 1.0) + 1.0)
