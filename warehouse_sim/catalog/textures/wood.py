"""Sawn softwood. A tile is three times as long along the grain as it is wide."""

import numpy as np

from warehouse_sim.catalog.noise import (
    Texels,
    octaves,
    offsets,
    smooth_step,
    softened,
    strokes,
    value_noise,
)
from warehouse_sim.catalog.textures.tile import SIZE, Tile

STRETCH = 3
"""Length of a tile along the grain over its width; the texture table of the catalog repeats it."""
_RINGS = 62
"""Growth rings across a tile: 8 mm apart in 0.5 m, as flat-sawn boards show them."""
_KNOTS = 14


def wood(rng: np.random.Generator) -> Tile:
    """Paint a plain-sawn board: growth rings that run along u and arch, knots they flow around, saw marks, checks."""
    rings = _RINGS * (np.arange(SIZE) + 0.5)[:, None] / SIZE
    rings = rings + 13.0 * value_noise(rng, SIZE, 1, 5) + 3.0 * value_noise(rng, SIZE, 3, 11)
    rings = rings + 0.5 * octaves(rng, SIZE, 8, 40, 2)
    knots, cores = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    for _ in range(_KNOTS):
        rings, knot, core = _grow_knot(rng, rings)
        knots, cores = np.maximum(knots, knot), np.maximum(cores, core)
    phase = rings - np.floor(rings)
    # Latewood darkens slowly through the season and ends with the winter. Rings fade and return along the board.
    latewood = smooth_step((phase - 0.25) / 0.65) * smooth_step((1.0 - phase) / 0.12)
    latewood = latewood * (0.4 + 0.8 * octaves(rng, SIZE, 2, 9, 2))
    fibres, streaks = octaves(rng, SIZE, 12, 160, 2), value_noise(rng, SIZE, 3, 48)
    dirt, bruises = octaves(rng, SIZE, 4, 4, 4), octaves(rng, SIZE, 9, 7, 3)
    checks = strokes(rng, SIZE, 22, (14.0, 60.0), (-0.03, 0.03), 0.02)
    pores = strokes(rng, SIZE, 1200, (3.0, 12.0), (-0.05, 0.05))
    sawn = _saw_marks(rng)
    albedo = 1.0 - 0.30 * latewood + 0.30 * (fibres - 0.5) + 0.14 * (streaks - 0.5) + 0.26 * (dirt - 0.5)
    albedo = albedo - 0.14 * smooth_step((bruises - 0.5) / 0.35) - 0.09 * pores - 0.45 * checks
    albedo = (albedo + 0.05 * sawn) * (1.0 - 0.42 * knots) * (1.0 - 0.25 * cores)
    height = 0.15 * latewood + 0.35 * (fibres - 0.5) - 0.8 * checks - 0.15 * pores + 0.4 * knots + 0.8 * sawn
    roughness = 1.0 + 0.10 * (fibres - 0.5) - 0.12 * latewood - 0.18 * knots + 0.10 * (dirt - 0.5)
    return Tile(albedo, height, roughness, STRETCH)


def _grow_knot(rng: np.random.Generator, rings: Texels) -> tuple[Texels, Texels, Texels]:
    """Return the rings bent around a new knot, the knot, and its dark rim and heart."""
    du, dv = offsets(SIZE, (rng.random(), rng.random()))
    radius = rng.uniform(0.008, 0.026)
    across = du * (STRETCH / rng.uniform(1.0, 1.7))
    squared = (across * across + dv * dv) / (radius * radius)
    # Rings pass above and below it, over a length of several radii along the grain.
    reach = (across * across / 7.0 + dv * dv) / (radius * radius)
    bent = rings - 1.1 * _RINGS * dv / (0.6 + reach)
    inside = smooth_step((1.15 - squared) / 0.3)
    bent = np.where(squared < 1.0, 3.2 * np.sqrt(squared), bent)
    rim = smooth_step(1.0 - np.abs(squared - 1.0) / 0.5)
    halo = 0.45 * smooth_step((3.5 - squared) / 3.0)
    heart = smooth_step(1.0 - squared / 0.12)
    return bent, np.maximum(0.75 * inside, halo), np.maximum(rim, heart)


def _saw_marks(rng: np.random.Generator) -> Texels:
    """Return the marks that a band saw leaves across the grain, -0.5 to 0.5, here and there."""
    rows, columns = np.mgrid[0:SIZE, 0:SIZE]
    turns = (88.0 * columns + 3.0 * rows) / SIZE + 2.5 * octaves(rng, SIZE, 9, 2, 3)
    fraction = turns - np.floor(turns)
    waves = smooth_step(2.0 * np.minimum(fraction, 1.0 - fraction)) * octaves(rng, SIZE, 60, 6, 2)
    return softened(waves * smooth_step((octaves(rng, SIZE, 5, 5, 3) - 0.5) / 0.2))
