"""Surfaces of buildings and goods as they are met: uneven at every scale from millimetres to half a metre.

A camera that is near sees the grain and one that is far the clouds, so each scale varies about as much as the next;
what is wider than a quarter of a tile stays even, so that no repeat shows. Contrasts are judged by eye against
photographs of warehouses (no source: a prior).
"""

import numpy as np

from warehouse_sim.catalog.noise import (
    Texels,
    displaced,
    grains,
    octaves,
    smooth_step,
    softened,
    strokes,
    value_noise,
)
from warehouse_sim.catalog.textures.tile import SIZE, Tile

LARGE = 2 * SIZE
"""Edge of the textures that fill a view, in texels."""
_COURSES, _BLOCKS = 12, 6
"""Blocks of a wall along v and u: 200 x 400 mm in 2.4 m."""
_FLUTES = 64
"""Flutes of board in a tile: 8 mm apart in 0.5 m, as in C-flute."""


def slab(rng: np.random.Generator) -> Tile:
    """Paint a power-trowelled slab: clouds, arcs of the trowel, sand, pores, tyre dust along u, cracks, splashes."""
    clouds = _clouds(rng, LARGE, (9, 18, 36, 72, 144, 288), (0.6, 0.5, 0.5, 0.5, 0.7, 0.9))
    sand = value_noise(rng, LARGE, LARGE, LARGE) - 0.5
    arcs = softened(strokes(rng, LARGE, 260, (40.0, 170.0), (-1.0, 1.0), 0.9))
    tyre = softened(softened(strokes(rng, LARGE, 120, (80.0, 420.0), (-0.12, 0.12), 0.1)))
    owner, near, _ = grains(rng, LARGE, 110)
    pores = smooth_step((0.10 * (rng.random(110 * 110)[owner] - 0.75) - near) / 0.012)
    way = 26.0 * (octaves(rng, LARGE, 9, 9, 5) - 0.5)
    cracks = displaced(strokes(rng, LARGE, 6, (160.0, 380.0), (-0.9, 0.9), 0.3), way, way.T)
    splashes = smooth_step((octaves(rng, LARGE, 13, 13, 4) - 0.64) / 0.06)
    albedo = 1.0 + 0.19 * clouds + 0.12 * sand + 0.07 * arcs - 0.10 * tyre - 0.32 * pores - 0.28 * cracks
    albedo = albedo - 0.13 * splashes
    height = -0.4 * pores - 0.3 * cracks
    roughness = 1.0 + 0.4 * (octaves(rng, LARGE, 9, 9, 4) - 0.5) - 0.12 * arcs + 0.2 * pores - 0.2 * splashes
    return Tile(albedo, height, roughness)


def coat(rng: np.random.Generator) -> Tile:
    """Paint a floor coating in use: haze, dust in the traces of a sweeper, rubber along u, drips, quartz specks."""
    haze = _clouds(rng, LARGE, (9, 18, 36, 72, 144), (0.6, 0.5, 0.5, 0.5, 0.7))
    swept = value_noise(rng, LARGE, 24, 300) - 0.5
    rubber = softened(strokes(rng, LARGE, 210, (60.0, 460.0), (-0.14, 0.14), 0.12))
    scuffs = strokes(rng, LARGE, 150, (12.0, 70.0), (-1.0, 1.0), 0.5)
    owner, near, _ = grains(rng, LARGE, 150)
    quartz = smooth_step((0.10 * (rng.random(150 * 150)[owner] - 0.72) - near) / 0.014)
    dried = smooth_step((octaves(rng, LARGE, 12, 14, 4) - 0.65) / 0.05)
    albedo = 1.0 + 0.16 * haze + 0.07 * swept - 0.16 * rubber - 0.10 * scuffs + 0.16 * quartz - 0.12 * dried
    height = 0.5 * octaves(rng, LARGE, 96, 96, 1) + 0.2 * scuffs
    roughness = 1.0 + 0.6 * (octaves(rng, LARGE, 9, 9, 4) - 0.5) + 0.35 * rubber + 0.3 * scuffs - 0.2 * dried
    return Tile(albedo, height, roughness)


def precast(rng: np.random.Generator) -> Tile:
    """Paint a painted wall of precast panels: roller marks, clouds, dirt that ran down along v, scuffs, joints."""
    clouds = _clouds(rng, LARGE, (9, 18, 36, 72, 144, 288), (0.5, 0.4, 0.4, 0.4, 0.5, 0.7))
    runs = octaves(rng, LARGE, 90, 7, 3) - 0.5
    drips = softened(strokes(rng, LARGE, 90, (40.0, 240.0), (5.0, 40.0)))
    scuffs = softened(strokes(rng, LARGE, 110, (15.0, 120.0), (-0.5, 0.5), 0.3))
    owner, near, _ = grains(rng, LARGE, 70)
    holes = smooth_step((0.08 * (rng.random(70 * 70)[owner] - 0.8) - near) / 0.012)
    joints = np.maximum(_line(LARGE, 0.5, 1.6)[None, :], _line(LARGE, 0.25, 1.6)[:, None])
    filled = smooth_step((octaves(rng, LARGE, 10, 10, 3) - 0.68) / 0.02)
    albedo = 1.0 + 0.20 * clouds - 0.18 * runs - 0.12 * drips - 0.15 * scuffs - 0.3 * holes - 0.30 * joints
    albedo = albedo + 0.07 * filled
    height = 6.0 * octaves(rng, LARGE, 9, 9, 2) - 0.5 * holes - 1.2 * joints
    roughness = 1.0 + 0.3 * (octaves(rng, LARGE, 9, 9, 4) - 0.5) + 0.1 * holes - 0.1 * filled
    return Tile(albedo, height, roughness)


def blockwork(rng: np.random.Generator) -> Tile:
    """Paint concrete blocks in running bond with struck joints: each block its own tone, open pores, lime."""
    rows, columns = np.mgrid[0:SIZE, 0:SIZE]
    course = rows * _COURSES // SIZE
    along = (columns + 0.5) * (_BLOCKS / SIZE) + 0.5 * (course % 2)
    block = np.floor(along).astype(int) % _BLOCKS
    tone = rng.random((_COURSES, _BLOCKS))[course, block] - 0.5
    fraction_u, fraction_v = along % 1.0, (rows + 0.5) * (_COURSES / SIZE) % 1.0
    edge_u = np.minimum(fraction_u, 1.0 - fraction_u) * (SIZE / _BLOCKS)
    edge_v = np.minimum(fraction_v, 1.0 - fraction_v) * (SIZE / _COURSES)
    mortar = smooth_step(1.6 - np.minimum(edge_u, edge_v))
    clouds = _clouds(rng, SIZE, (10, 20, 40, 80, 160), (0.4, 0.45, 0.6, 0.8, 1.0))
    owner, near, _ = grains(rng, SIZE, 120)
    pores = smooth_step((0.16 * (rng.random(120 * 120)[owner] - 0.5) - near) / 0.02)
    lime = smooth_step((octaves(rng, SIZE, 9, 13, 4) - 0.62) / 0.08)
    albedo = 1.0 + 0.15 * tone + 0.16 * clouds - 0.22 * pores + 0.10 * mortar + 0.10 * lime
    height = -0.6 * pores - 1.3 * mortar
    return Tile(albedo, height, 1.0 + 0.1 * clouds)


def liner(rng: np.random.Generator) -> Tile:
    """Paint board that was packed and carried: mottled fibre, flutes along v, scuffs, rubs, dents, hand marks."""
    clouds = _clouds(rng, SIZE, (8, 16, 32, 64, 128), (0.4, 0.5, 0.7, 0.8, 0.8))
    fibres = strokes(rng, SIZE, 3500, (3.0, 14.0), (-1.0, 1.0), 3.0)
    fibres = fibres + strokes(rng, SIZE, 2500, (3.0, 14.0), (-1.0, 1.0), 3.0).T
    place = (np.arange(SIZE) + 0.5) * (_FLUTES / SIZE)
    fraction = place - np.floor(place)
    flutes = smooth_step(2.0 * np.minimum(fraction, 1.0 - fraction))[None, :] * (0.4 + octaves(rng, SIZE, 6, 6, 3))
    scuffs = softened(strokes(rng, SIZE, 60, (12.0, 90.0), (-0.8, 0.8), 0.4))
    rubs = softened(strokes(rng, SIZE, 26, (30.0, 130.0), (-0.15, 0.15), 0.2))
    marks = smooth_step((octaves(rng, SIZE, 10, 10, 4) - 0.62) / 0.10)
    albedo = 1.0 + 0.15 * clouds - 0.07 * fibres - 0.05 * flutes + 0.10 * scuffs - 0.14 * rubs - 0.10 * marks
    height = 0.22 * flutes + 1.6 * octaves(rng, SIZE, 9, 9, 3) + 0.06 * fibres - 0.3 * scuffs
    return Tile(albedo, height, 1.0 + 0.12 * clouds - 0.04 * flutes + 0.06 * scuffs)


def enamel(rng: np.random.Generator) -> Tile:
    """Paint coated steel after some years: orange peel, dust, rubs and scratches along u, chips, finger marks."""
    dust = _clouds(rng, SIZE, (8, 16, 32, 64, 128), (0.1, 0.2, 0.3, 0.5, 0.6))
    peel = softened(octaves(rng, SIZE, 96, 96, 2)) - 0.5
    scratches = strokes(rng, SIZE, 130, (15.0, 150.0), (-0.3, 0.3), 0.2)
    rubs = smooth_step((octaves(rng, SIZE, 8, 40, 3) - 0.60) / 0.12)
    owner, near, _ = grains(rng, SIZE, 30)
    chips = smooth_step((0.012 * (rng.random(30 * 30)[owner] - 0.9) / 0.1 - near) / 0.003)
    albedo = 1.0 + 0.18 * dust + 0.20 * scratches - 0.12 * rubs - 0.45 * chips
    height = 0.5 * peel - 0.25 * scratches - 0.4 * chips
    roughness = 1.0 + 0.35 * dust + 0.25 * scratches + 0.25 * rubs + 0.4 * chips
    return Tile(albedo, height, roughness)


def _clouds(rng: np.random.Generator, size: int, cells: tuple[int, ...], weights: tuple[float, ...]) -> Texels:
    """Return a sum of noises about 0, one for each number of ``cells`` along an edge, each of its own strength."""
    total = np.zeros((size, size))
    for number, weight in zip(cells, weights, strict=True):
        total += weight * (value_noise(rng, size, number, number) - 0.5)
    return total


def _line(size: int, place: float, half: float) -> np.ndarray:
    """Return a soft line, 1 in its middle, at ``place`` (0-1) along an edge; ``half`` its half width in texels."""
    return smooth_step(1.5 - np.abs(np.arange(size) + 0.5 - place * size) / half)
