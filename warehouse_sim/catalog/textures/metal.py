"""Sheet metal: painted, hot-dip galvanised and brushed."""

import numpy as np

from warehouse_sim.catalog.noise import grains, octaves, smooth_step, softened, strokes, value_noise
from warehouse_sim.catalog.textures.tile import SIZE, Tile

_SPANGLES = 26
"""Crystals along an edge of a tile: 15 mm each in 0.4 m."""


def steel(rng: np.random.Generator) -> Tile:
    """Paint powder-coated steel in use: orange peel, dust, scratches along u and a few chips."""
    peel = softened(octaves(rng, SIZE, 96, 96, 2))
    dust = octaves(rng, SIZE, 5, 5, 4)
    scratches = strokes(rng, SIZE, 60, (15.0, 130.0), (-0.25, 0.25), 0.15)
    scuffs = smooth_step((value_noise(rng, SIZE, 16, 160) - 0.86) / 0.14)
    owner, near, _ = grains(rng, SIZE, 24)
    chips = smooth_step((0.025 * (rng.random(24 * 24)[owner] - 0.95) / 0.05 - near) / 0.004)
    albedo = 1.0 + 0.12 * (dust - 0.5) - 0.09 * scuffs + 0.16 * scratches - 0.4 * chips
    height = 0.5 * (peel - 0.5) - 0.25 * scratches - 0.4 * chips
    roughness = 1.0 + 0.45 * (dust - 0.5) + 0.30 * scuffs + 0.25 * scratches + 0.4 * chips
    return Tile(albedo, height, roughness)


def galvanised(rng: np.random.Generator) -> Tile:
    """Paint hot-dip galvanised sheet: spangles of crystals that each face their own way, frost, white stains."""
    owner, near, far = grains(rng, SIZE, _SPANGLES)
    shine, gloss = rng.random((2, _SPANGLES * _SPANGLES))
    border = smooth_step(1.0 - (far - near) / 0.05)
    feathers, stain = octaves(rng, SIZE, 128, 128, 2), octaves(rng, SIZE, 4, 5, 4)
    albedo = 1.0 + 0.24 * (shine[owner] - 0.5) + 0.10 * (feathers - 0.5) + 0.16 * (stain - 0.5) - 0.05 * border
    height = 0.2 * (feathers - 0.5) - 0.1 * border
    roughness = 1.0 + 0.5 * (gloss[owner] - 0.5) + 0.2 * (feathers - 0.5) + 0.35 * (stain - 0.5)
    return Tile(albedo, height, roughness)


def brushed(rng: np.random.Generator) -> Tile:
    """Paint brushed metal: fine lines along u."""
    coarse, fine = value_noise(rng, SIZE, 6, 170), value_noise(rng, SIZE, 12, 512)
    lines = 0.5 * coarse + 0.5 * fine
    smudges = octaves(rng, SIZE, 4, 4, 3)
    scratches = strokes(rng, SIZE, 50, (20.0, 160.0), (-0.02, 0.02))
    albedo = 1.0 + 0.16 * (lines - 0.5) + 0.06 * (smudges - 0.5) - 0.08 * scratches
    height = 0.30 * (lines - 0.5) - 0.2 * scratches
    roughness = 1.0 + 0.3 * (lines - 0.5) + 0.4 * (smudges - 0.5)
    return Tile(albedo, height, roughness)
