"""Floors: trowelled concrete and epoxy coating. Contrast is low where features are large, so that no repeat shows."""

import numpy as np

from warehouse_sim.catalog.noise import (
    displaced,
    grains,
    octaves,
    ridges,
    smooth_step,
    softened,
    strokes,
    value_noise,
)
from warehouse_sim.catalog.textures.tile import SIZE, Tile


def concrete(rng: np.random.Generator) -> Tile:
    """Paint a trowelled slab: blotches, trowel swirls, sand, pores and hairline cracks."""
    blotches, sand = octaves(rng, SIZE, 6, 6, 6), value_noise(rng, SIZE, SIZE, SIZE)
    fine = octaves(rng, SIZE, 90, 90, 3)
    swirls = ridges(octaves(rng, SIZE, 9, 7, 3), 0.05)
    owner, near, _ = grains(rng, SIZE, 90)
    pores = smooth_step((0.09 * (rng.random(90 * 90)[owner] - 0.8) - near) / 0.012)
    way = 14.0 * (octaves(rng, SIZE, 6, 6, 5) - 0.5)
    hair = displaced(strokes(rng, SIZE, 5, (90.0, 200.0), (-0.9, 0.9), 0.3), way, way.T)
    scratches = strokes(rng, SIZE, 24, (10.0, 60.0), (-1.0, 1.0), 0.3)
    albedo = (
        1.0
        + 0.34 * (blotches - 0.5)
        + 0.22 * (fine - 0.5)
        + 0.10 * (sand - 0.5)
        + 0.03 * swirls
        - 0.30 * pores
        - 0.13 * hair
        + 0.05 * scratches
    )
    height = 0.3 * (fine - 0.5) + 0.12 * (sand - 0.5) - 0.4 * pores - 0.15 * hair
    roughness = 1.0 + 0.5 * (blotches - 0.5) + 0.3 * (fine - 0.5) - 0.10 * swirls + 0.2 * pores
    return Tile(albedo, height, roughness)


def epoxy(rng: np.random.Generator) -> Tile:
    """Paint a glossy floor coating: roller texture, dust, and the haze and streaks that tyres leave along u."""
    roller = softened(octaves(rng, SIZE, 64, 64, 2))
    dust, haze = octaves(rng, SIZE, 5, 5, 5), octaves(rng, SIZE, 6, 9, 4)
    streaks = softened(strokes(rng, SIZE, 70, (40.0, 260.0), (-0.12, 0.12), 0.12))
    tyre = smooth_step((haze - 0.35) / 0.45)
    specks = smooth_step((value_noise(rng, SIZE, 256, 256) - 0.95) / 0.05)
    albedo = 1.0 + 0.10 * (dust - 0.5) - 0.07 * tyre - 0.08 * streaks - 0.12 * specks
    height = 0.3 * (roller - 0.5)
    roughness = 1.0 + 0.55 * (dust - 0.5) + 0.35 * tyre + 0.30 * streaks + 0.3 * specks
    return Tile(albedo, height, roughness)
