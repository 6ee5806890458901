"""Kraft liner of corrugated board."""

import numpy as np

from warehouse_sim.catalog.noise import octaves, smooth_step, softened, strokes, value_noise
from warehouse_sim.catalog.textures.tile import SIZE, Tile

_FLUTES = 50
"""Flutes in a tile: 8 mm apart in 0.4 m, as in C-flute."""


def kraft(rng: np.random.Generator) -> Tile:
    """Paint kraft liner: fibres in all directions on a cloudy ground, flutes that show through along v, scuffs."""
    fibres = strokes(rng, SIZE, 3500, (3.0, 14.0), (-1.0, 1.0), 3.0)
    fibres = fibres + strokes(rng, SIZE, 2500, (3.0, 14.0), (-1.0, 1.0), 3.0).T
    specks = smooth_step((value_noise(rng, SIZE, 256, 256) - 0.93) / 0.07)
    place = (np.arange(SIZE) + 0.5) * (_FLUTES / SIZE)
    fraction = place - np.floor(place)
    flutes = smooth_step(2.0 * np.minimum(fraction, 1.0 - fraction))[None, :] * (0.5 + octaves(rng, SIZE, 3, 3, 2))
    clouds, dents = octaves(rng, SIZE, 6, 6, 4), octaves(rng, SIZE, 5, 5, 2)
    scuffs = strokes(rng, SIZE, 14, (15.0, 80.0), (-0.8, 0.8), 0.4)
    albedo = (
        1.0 + 0.13 * (clouds - 0.5) - 0.07 * (fibres - 0.2) - 0.18 * specks - 0.022 * flutes + 0.07 * softened(scuffs)
    )
    height = 0.14 * flutes + 1.0 * dents + 0.06 * fibres - 0.2 * scuffs
    roughness = 1.0 + 0.10 * (clouds - 0.5) - 0.04 * flutes + 0.06 * scuffs
    return Tile(albedo, height, roughness)
