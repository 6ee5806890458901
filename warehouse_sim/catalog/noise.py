"""Tileable noise on a square of texels, from sums and products only, so that it comes out alike on every machine."""

import numpy as np
from jaxtyping import Float, Int

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
    rows, row_fraction = _cells(size, cells_v)
    columns, column_fraction = _cells(size, cells_u)
    below, right = (rows + 1) % cells_v, (columns + 1) % cells_u
    upper = _mix(lattice[np.ix_(rows, columns)], lattice[np.ix_(rows, right)], column_fraction)
    lower = _mix(lattice[np.ix_(below, columns)], lattice[np.ix_(below, right)], column_fraction)
    return _mix(upper, lower, row_fraction[:, None])


def octaves(rng: np.random.Generator, size: int, cells_u: int, cells_v: int, count: int) -> Texels:
    """Return the mean of ``count`` noises, each twice as fine and half as strong as the one before; 0-1."""
    total, weight = np.zeros((size, size)), 0.0
    for octave in range(count):
        total += value_noise(rng, size, cells_u << octave, cells_v << octave) / (1 << octave)
        weight += 1.0 / (1 << octave)
    return total / weight


def displaced(texels: Texels, shift_u: Texels, shift_v: Texels) -> Texels:
    """Return ``texels`` read bilinearly at places moved by ``shift_u`` and ``shift_v`` (texels), around the edges."""
    size = len(texels)
    rows, columns = np.mgrid[0:size, 0:size]
    u, v = columns + shift_u, rows + shift_v
    left, top = np.floor(u).astype(int), np.floor(v).astype(int)
    fraction_u, fraction_v = u - left, v - top
    left, top = left % size, top % size
    right, below = (left + 1) % size, (top + 1) % size
    upper = _mix(texels[top, left], texels[top, right], fraction_u)
    lower = _mix(texels[below, left], texels[below, right], fraction_u)
    return _mix(upper, lower, fraction_v)


def grains(
    rng: np.random.Generator, size: int, cells: int
) -> tuple[Int[np.ndarray, "n n"], Texels, Float[np.ndarray, "n n"]]:
    """Return cells of random shape about one point in each square of a ``cells`` x ``cells`` lattice.

    After Worley, "A cellular texture basis function", SIGGRAPH 1996.

    Returns:
        The number of each texel's cell, 0 to ``cells**2 - 1``; the squared distance to its point and that to the next
        nearest one, in squared edges of the lattice.
    """
    points = rng.random((cells, cells, 2))
    place = (np.arange(size) + 0.5) * (cells / size)
    column = np.floor(place).astype(int)
    owner = np.zeros((size, size), int)
    first, second = np.full((size, size), 9.0), np.full((size, size), 9.0)
    for dv in (-1, 0, 1):
        for du in (-1, 0, 1):
            i, j = (column + dv)[:, None], (column + du)[None, :]
            point = points[i % cells, j % cells]
            squared = (j + point[..., 0] - place[None, :]) ** 2 + (i + point[..., 1] - place[:, None]) ** 2
            nearer = squared < first
            second = np.where(nearer, first, np.minimum(second, squared))
            owner = np.where(nearer, i % cells * cells + j % cells, owner)
            first = np.where(nearer, squared, first)
    return owner, first, second


def strokes(
    rng: np.random.Generator,
    size: int,
    count: int,
    length: tuple[float, float],
    slope: tuple[float, float],
    bend: float = 0.0,
) -> Texels:
    """Return thin lines of strength 0-1 that fade out at both ends, on zero.

    Args:
        rng: Stream to draw from.
        size: Edge of the square in texels.
        count: Number of lines.
        length: Least and greatest length (texels).
        slope: Least and greatest step along v for a step of one along u; steep lines step along v instead.
        bend: Greatest change of that slope over 100 texels, either way.
    """
    sampled = np.zeros((size, size))
    for _ in range(count):
        u, v = rng.uniform(0.0, size, 2)
        steps = np.arange(int(rng.uniform(*length)))
        rise = rng.uniform(*slope) + rng.uniform(-bend, bend) * steps / 100.0
        strength = rng.uniform(0.3, 1.0) * smooth_step(4.0 * np.minimum(steps + 1, steps[::-1] + 1) / (len(steps) + 1))
        columns, places = np.floor(u).astype(int) + steps, v + np.cumsum(rise)
        rows = np.floor(places).astype(int)
        fraction = places - rows
        for row, part in ((rows, 1.0 - fraction), (rows + 1, fraction)):
            np.maximum.at(sampled, (row % size, columns % size), strength * part)
    return sampled


def offsets(size: int, centre: tuple[float, float]) -> tuple[Texels, Texels]:
    """Return the way from ``centre`` (u, v; 0-1) to each texel along u and v, the short way around, -0.5 to 0.5."""
    places = (np.arange(size) + 0.5) / size
    du, dv = np.meshgrid(places - centre[0], places - centre[1])
    return du - np.round(du), dv - np.round(dv)


def smooth_step(fraction: np.ndarray) -> np.ndarray:
    """Return the cubic that goes from 0 to 1 with level ends, for ``fraction`` cut to 0-1."""
    fraction = np.clip(fraction, 0.0, 1.0)
    return fraction * fraction * (3.0 - 2.0 * fraction)


def ridges(noise: Texels, width: float) -> Texels:
    """Return lines, 1 on their crest, along which ``noise`` passes through its middle 0.5; ``width`` in its values."""
    return smooth_step(1.0 - np.abs(noise - 0.5) / width)


def softened(texels: Texels) -> Texels:
    """Return the texels after a 3 x 3 binomial filter that goes around the edges."""
    for axis in (0, 1):
        texels = 0.25 * (np.roll(texels, 1, axis) + np.roll(texels, -1, axis)) + 0.5 * texels
    return texels


def _cells(size: int, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the cell of each texel along one edge and the smoothed place inside it."""
    place = (np.arange(size) + 0.5) * (cells / size)
    cell = np.floor(place).astype(int)
    return cell, smooth_step(place - cell)


def _mix(a: np.ndarray, b: np.ndarray, fraction: np.ndarray) -> np.ndarray:
    return a + (b - a) * fraction
