"""Detail textures of the materials: factors on the albedo, stored as grey levels of which 128 means "no change".

Rows are v, columns are u. Each texture tiles without seams and comes from its own fixed seed.
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import UInt8

from warehouse_sim.catalog.noise import Texels, octaves, offsets, smooth_step, value_noise

SIZE = 256
"""Edge of a texture in texels."""
NEUTRAL = 128
"""Grey level that leaves the albedo as it is."""


def wood(rng: np.random.Generator) -> Texels:
    """Return sawn softwood: growth rings and fibres along u, a few knots that the rings flow around."""
    rings = 9.0 * (np.arange(SIZE) + 0.5)[:, None] / SIZE + 2.2 * octaves(rng, SIZE, 2, 3, 2)
    dark = np.zeros((SIZE, SIZE))
    for _ in range(3):
        du, dv = offsets(SIZE, (rng.random(), rng.random()))
        radius = rng.uniform(0.012, 0.028)
        squared = (du * du / 6.0 + dv * dv) / (radius * radius)
        rings = rings + 1.6 * dv / radius / (1.0 + squared)
        dark = np.maximum(dark, smooth_step(1.4 - squared))
    phase = rings - np.floor(rings)
    latewood = smooth_step(phase / 0.8) * smooth_step((1.0 - phase) / 0.2)
    fibres = octaves(rng, SIZE, 4, 64, 2)
    stain = octaves(rng, SIZE, 2, 4, 3)
    return 1.0 - 0.26 * (latewood - 0.4) + 0.34 * (fibres - 0.5) + 0.5 * (stain - 0.5) - 0.5 * dark


def kraft(rng: np.random.Generator) -> Texels:
    """Return kraft liner: short fibres in all directions on a faintly cloudy ground, flutes showing through along v."""
    fibres = np.zeros((SIZE, SIZE))
    steps = np.arange(14)
    for _ in range(900):
        row, column = rng.integers(SIZE, size=2)
        slope_u, slope_v = rng.uniform(-1.0, 1.0, 2)
        rows = (row + np.floor(steps * slope_v).astype(int)) % SIZE
        columns = (column + np.floor(steps * slope_u).astype(int)) % SIZE
        fibres[rows, columns] += rng.uniform(-1.0, 1.0)
    place = (np.arange(SIZE) + 0.5) * (64.0 / SIZE)
    flutes = np.abs(place - np.floor(place) - 0.5)[None, :] - 0.25
    clouds = octaves(rng, SIZE, 5, 5, 3)
    return 1.0 + 0.07 * np.clip(fibres, -2.0, 2.0) + 0.24 * (clouds - 0.5) + 0.06 * flutes


def concrete(rng: np.random.Generator) -> Texels:
    """Return a trowelled slab: blotches of all sizes, too faint for the repeat to show, fine sand and small pits."""
    blotches, sand = octaves(rng, SIZE, 4, 4, 6), value_noise(rng, SIZE, SIZE, SIZE)
    swirls = octaves(rng, SIZE, 9, 7, 3)
    worn = smooth_step(np.abs(swirls - 0.5) / 0.12)
    pits = smooth_step((value_noise(rng, SIZE, 96, 96) - 0.93) / 0.07)
    return 1.0 + 0.55 * (blotches - 0.5) + 0.12 * (sand - 0.5) + 0.05 * worn - 0.25 * pits


def steel(rng: np.random.Generator) -> Texels:
    """Return painted sheet in use: nearly even, with faint dust and short scuffs along u."""
    dust = octaves(rng, SIZE, 4, 4, 3)
    scuffs = smooth_step((value_noise(rng, SIZE, 12, 128) - 0.86) / 0.14)
    return 1.0 + 0.14 * (dust - 0.5) - 0.16 * scuffs


TEXTURES: dict[str, Callable[[np.random.Generator], Texels]] = {
    texture.__name__: texture for texture in (wood, kraft, concrete, steel)
}
"""Name, as in ``Material.texture`` -> the function that paints it."""


def paint(name: str) -> UInt8[np.ndarray, "256 256"]:
    """Return the grey levels of the texture called ``name``; their mean is ``NEUTRAL`` to within half a level."""
    rng = np.random.default_rng([2026, list(TEXTURES).index(name)])
    factors = TEXTURES[name](rng)
    # The mean is taken of whole numbers: sums of floats may differ in the last bit between processors.
    levels = np.round(factors * (NEUTRAL * 64)).astype(np.int64)
    mean = int(levels.sum()) // levels.size
    return np.clip((levels - mean + NEUTRAL * 64 + 32) // 64, 0, 255).astype(np.uint8)
