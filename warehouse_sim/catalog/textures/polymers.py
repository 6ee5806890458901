"""Moulded plastic, stretch film and rubber."""

import numpy as np

from warehouse_sim.catalog.noise import (
    displaced,
    octaves,
    ridges,
    smooth_step,
    softened,
    strokes,
    value_noise,
)
from warehouse_sim.catalog.textures.tile import SIZE, Tile


def plastic(rng: np.random.Generator) -> Tile:
    """Paint moulded polyolefin in use: the grain of the eroded mould, whitish scuffs, dust."""
    grain = softened(value_noise(rng, SIZE, 256, 256))
    flow, dust = octaves(rng, SIZE, 3, 5, 3), octaves(rng, SIZE, 8, 8, 4)
    scuffs = strokes(rng, SIZE, 70, (8.0, 70.0), (-0.7, 0.7), 0.3)
    albedo = 1.0 + 0.06 * (grain - 0.5) + 0.05 * (flow - 0.5) + 0.12 * (dust - 0.5) + 0.14 * scuffs
    height = 0.5 * (grain - 0.5) + 2.0 * flow - 0.2 * scuffs
    roughness = 1.0 + 0.15 * (grain - 0.5) + 0.35 * (dust - 0.5) + 0.25 * scuffs
    return Tile(albedo, height, roughness)


def film(rng: np.random.Generator) -> Tile:
    """Paint stretch film: sharp wrinkles that run mostly along u, pulled tight in between."""
    twist = 26.0 * (octaves(rng, SIZE, 2, 2, 3) - 0.5)
    wide = displaced(ridges(octaves(rng, SIZE, 2, 9, 3), 0.05), twist, twist.T)
    fine = displaced(ridges(octaves(rng, SIZE, 3, 22, 3), 0.06), -twist, twist.T)
    cross = ridges(octaves(rng, SIZE, 7, 4, 3), 0.025)
    here = smooth_step((octaves(rng, SIZE, 3, 3, 2) - 0.3) / 0.4)
    creases = wide + 0.6 * fine * here + 0.5 * cross * (1.0 - here)
    albedo = 1.0 + 0.35 * (creases - 0.4) + 0.1 * (octaves(rng, SIZE, 5, 5, 3) - 0.5)
    height = softened(1.7 * creases + 6.0 * octaves(rng, SIZE, 3, 6, 2))
    roughness = 1.0 + 0.5 * (octaves(rng, SIZE, 5, 5, 3) - 0.5) + 0.2 * creases
    return Tile(albedo, height, roughness)


def rubber(rng: np.random.Generator) -> Tile:
    """Paint rubber: fine grain, grey abrasion and dust."""
    grain, dust = octaves(rng, SIZE, 160, 160, 2), octaves(rng, SIZE, 6, 6, 5)
    damaged = smooth_step((octaves(rng, SIZE, 40, 48, 3) - 0.5) / 0.35)
    albedo = 1.0 + 0.5 * (dust - 0.5) + 0.25 * (grain - 0.5) + 0.3 * damaged
    height = 0.8 * (grain - 0.5)
    roughness = 1.0 + 0.12 * (dust - 0.5) + 0.10 * (grain - 0.5) + 0.06 * damaged
    return Tile(albedo, height, roughness)
