"""Tileable noise on a square of texels, from sums and products only, so that it comes out alike on every machine."""

import numpy as np
from jaxtyping import Float

Texels = Float[np.ndarray, "n n"]


def value_noise(rng: np.random.Generator, size: int, cells_u: int, cells_v: int) -> Texels:
    """Return smooth random values 0-1 on a lattice of ``cells_v`` x ``cells_u`` cells that wraps around.

    Args:
        rng: Stream to draw from.
        size: Edge of the square in texels; rows are v, columns are u.
        cells_u: Cells along u; few cells give long features.
        cells_v: Cells along v.
    """
    lattice = rng.random((cells_v, cells_u))
    rows, row_share = _cells(size, cells_v)
    columns, column_share = _cells(size, cells_u)
    below, right = (rows + 1) % cells_v, (columns + 1) % cells_u
    upper = _mix(lattice[np.ix_(rows, columns)], lattice[np.ix_(rows, right)], column_share)
    lower = _mix(lattice[np.ix_(below, columns)], lattice[np.ix_(below, right)], column_share)
    return _mix(upper, lower, row_share[:, None])


def octaves(rng: np.random.Generator, size: int, cells_u: int, cells_v: int, count: int) -> Texels:
    """Return the mean of ``count`` noises, each twice as fine and half as strong as the one before; 0-1."""
    total, weight = np.zeros((size, size)), 0.0
    for octave in range(count):
        total += value_noise(rng, size, cells_u << octave, cells_v << octave) / (1 << octave)
        weight += 1.0 / (1 << octave)
    return total / weight


def offsets(size: int, centre: tuple[float, float]) -> tuple[Texels, Texels]:
    """Return the way from ``centre`` (u, v; 0-1) to each texel along u and v, the short way around, -0.5 to 0.5."""
    places = (np.arange(size) + 0.5) / size
    du, dv = np.meshgrid(places - centre[0], places - centre[1])
    return du - np.round(du), dv - np.round(dv)


def smooth_step(share: Texels) -> Texels:
    """Return the cubic that goes from 0 to 1 with level ends, for ``share`` cut to 0-1."""
    share = np.clip(share, 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


def _cells(size: int, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the cell of each texel along one edge and the smoothed place inside it."""
    place = (np.arange(size) + 0.5) * (cells / size)
    cell = np.floor(place).astype(int)
    return cell, smooth_step(place - cell)


def _mix(a: np.ndarray, b: np.ndarray, share: np.ndarray) -> np.ndarray:
    return a + (b - a) * share
