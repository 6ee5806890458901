"""Surfaces after years of use: what fresh ones show, tiled, with stains, patches, runs and scratches over it.

Each is twice as wide as the fresh texture that it is made of, in texels and in metres, so that marks lie far apart.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import wraps

import numpy as np

from warehouse_sim.catalog.noise import Texels, displaced, octaves, offsets, smooth_step, softened, strokes
from warehouse_sim.catalog.textures.fresh import plastic, wood
from warehouse_sim.catalog.textures.tile import SIZE, Tile
from warehouse_sim.catalog.textures.used import coat, enamel, liner, slab

WIDE = 2 * SIZE
"""Edge of a worn texture in texels."""

Wear = Callable[[Tile, np.random.Generator], Tile]


def _over(fresh: Callable[[np.random.Generator], Tile]) -> Callable[[Wear], Callable[[np.random.Generator], Tile]]:
    """Make a painter of what wears a fresh texture, laid out two by two."""

    def doubled(rng: np.random.Generator) -> Tile:
        tile = fresh(rng)
        albedo, height, roughness = (np.tile(item, (2, 2)) for item in (tile.albedo, tile.height, tile.roughness))
        return replace(tile, albedo=albedo, height=height, roughness=roughness)

    return _on(doubled)


def _on(wide: Callable[[np.random.Generator], Tile]) -> Callable[[Wear], Callable[[np.random.Generator], Tile]]:
    """Make a painter of what wears a texture that is as wide as a damaged one."""

    def made(wear: Wear) -> Callable[[np.random.Generator], Tile]:
        @wraps(wear)
        def painter(rng: np.random.Generator) -> Tile:
            return wear(wide(rng), rng)

        del painter.__wrapped__  # what it takes is a stream, not a tile
        return painter

    return made


@_on(slab)
def concrete_worn(tile: Tile, rng: np.random.Generator) -> Tile:
    """Paint a slab in use: oil and water stains, filled holes, tyre dust along u, cracks that branch."""
    oil, rim = _spots(rng, 60, (0.004, 0.05))
    patch = np.maximum(_slab(rng, (0.10, 0.05)), _slab(rng, (0.04, 0.07)))
    tyre = softened(strokes(rng, WIDE, 150, (60.0, 420.0), (-0.10, 0.10), 0.1))
    lanes = octaves(rng, WIDE, 3, 22, 3)
    way = 30.0 * (octaves(rng, WIDE, 8, 8, 4) - 0.5)
    cracks = displaced(strokes(rng, WIDE, 9, (150.0, 420.0), (-0.9, 0.9), 0.4), way, way.T)
    stain = smooth_step((octaves(rng, WIDE, 11, 10, 5) - 0.52) / 0.12)
    albedo = tile.albedo * (1.0 - 0.42 * oil - 0.10 * rim - 0.22 * stain) + 0.15 * patch
    albedo = albedo - 0.13 * tyre - 0.16 * (lanes - 0.5) - 0.45 * cracks
    roughness = tile.roughness * (1.0 - 0.35 * oil) - 0.15 * stain + 0.1 * tyre
    return Tile(albedo, tile.height * (1.0 - 0.6 * patch) - 0.5 * cracks, roughness)


@_on(coat)
def epoxy_worn(tile: Tile, rng: np.random.Generator) -> Tile:
    """Paint a coat in use: black rubber along u, dried puddles, places worn through to the slab."""
    tyre = softened(strokes(rng, WIDE, 260, (60.0, 500.0), (-0.12, 0.12), 0.1))
    oil, rim = _spots(rng, 50, (0.004, 0.045))
    damaged = smooth_step((octaves(rng, WIDE, 9, 7, 5) - 0.62) / 0.05)
    albedo = tile.albedo - 0.30 * tyre - 0.30 * oil - 0.14 * rim + 0.12 * damaged
    roughness = tile.roughness + 0.3 * tyre + 0.35 * damaged - 0.2 * oil
    return Tile(albedo, tile.height + 0.3 * (softened(damaged) - 0.5), roughness)


@_over(enamel)
def steel_worn(tile: Tile, rng: np.random.Generator) -> Tile:
    """Paint steel after many impulses: scratches, chips with dark primer, rubbed edges of black, dust that ran."""
    scratches = strokes(rng, WIDE, 320, (20.0, 200.0), (-0.5, 0.5), 0.3)
    chips, _ = _spots(rng, 110, (0.0015, 0.006))
    runs = softened(strokes(rng, WIDE, 60, (60.0, 260.0), (4.0, 9.0)))
    rubbed = smooth_step((octaves(rng, WIDE, 5, 28, 4) - 0.58) / 0.1)
    grime = octaves(rng, WIDE, 7, 7, 5)
    albedo = tile.albedo + 0.22 * scratches - 0.55 * chips - 0.16 * runs - 0.20 * rubbed - 0.3 * (grime - 0.5)
    roughness = tile.roughness + 0.3 * scratches + 0.5 * chips + 0.3 * (grime - 0.5)
    return Tile(albedo, tile.height - 0.3 * scratches - 0.5 * chips, roughness)


@_over(wood)
def wood_worn(tile: Tile, rng: np.random.Generator) -> Tile:
    """Paint boards that lay outdoors: grey and brown runs, wet ends, black scrapes along u, splinters."""
    wet = smooth_step((octaves(rng, WIDE, 10, 16, 5) - 0.50) / 0.14)
    grey = octaves(rng, WIDE, 4, 40, 4)
    scrapes = softened(strokes(rng, WIDE, 120, (20.0, 140.0), (-0.2, 0.2), 0.1))
    spots, _ = _spots(rng, 60, (0.002, 0.012))
    splits = strokes(rng, WIDE, 60, (40.0, 200.0), (-0.03, 0.03), 0.02)
    albedo = tile.albedo * (1.0 - 0.28 * wet - 0.35 * spots) + 0.24 * (grey - 0.5) - 0.20 * scrapes - 0.45 * splits
    return replace(tile, albedo=albedo, height=tile.height - 0.8 * splits, roughness=tile.roughness - 0.08 * wet)


@_over(liner)
def kraft_worn(tile: Tile, rng: np.random.Generator) -> Tile:
    """Paint board that was handled: dark hands, rubbed-off print, water, creases and dents."""
    water = smooth_step((octaves(rng, WIDE, 5, 6, 4) - 0.60) / 0.04)
    scuffs = softened(strokes(rng, WIDE, 130, (20.0, 120.0), (-0.9, 0.9), 0.5))
    creases = softened(strokes(rng, WIDE, 22, (60.0, 260.0), (-0.6, 0.6), 0.3))
    dirt = octaves(rng, WIDE, 9, 9, 5)
    albedo = tile.albedo - 0.13 * water + 0.15 * scuffs - 0.16 * creases - 0.34 * (dirt - 0.5)
    return Tile(albedo, tile.height - 1.4 * creases, tile.roughness + 0.1 * scuffs)


@_over(plastic)
def plastic_worn(tile: Tile, rng: np.random.Generator) -> Tile:
    """Paint smooth sheet and plastic in use: black scuffs, dust, and what rain and condensate drew down along v."""
    scuffs = softened(strokes(rng, WIDE, 150, (15.0, 160.0), (-0.4, 0.4), 0.3))
    runs = octaves(rng, WIDE, 60, 4, 3)
    grime = octaves(rng, WIDE, 6, 6, 5)
    spots, _ = _spots(rng, 40, (0.001, 0.006))
    albedo = tile.albedo - 0.28 * scuffs - 0.24 * (runs - 0.5) - 0.26 * (grime - 0.5) - 0.35 * spots
    roughness = tile.roughness + 0.3 * scuffs + 0.4 * (grime - 0.5)
    return Tile(albedo, tile.height, roughness)


def _spots(rng: np.random.Generator, count: int, radius: tuple[float, float]) -> tuple[Texels, Texels]:
    """Return splashes of random outline and their rims, 0-1; radii as fractions of the tile."""
    inside, rims = np.zeros((WIDE, WIDE)), np.zeros((WIDE, WIDE))
    outline = octaves(rng, WIDE, 48, 48, 4)
    for _ in range(count):
        size = radius[0] * (radius[1] / radius[0]) ** float(rng.random() ** 2)
        column, row = rng.integers(0, WIDE, 2)
        edge = int(np.ceil(2.4 * size * WIDE))
        rows, columns = (row + np.arange(-edge, edge + 1)) % WIDE, (column + np.arange(-edge, edge + 1)) % WIDE
        du, dv = np.meshgrid(np.arange(-edge, edge + 1) / WIDE, np.arange(-edge, edge + 1) / WIDE)
        place = np.ix_(rows, columns)
        tall = rng.uniform(0.6, 1.6) * dv
        distance = np.sqrt(du * du + tall * tall) / size + 1.9 * (outline[place] - 0.5)
        strength, soft = rng.uniform(0.15, 0.9), rng.uniform(0.1, 0.6)
        inside[place] = np.maximum(inside[place], strength * smooth_step((1.0 + soft / 2 - distance) / soft))
        rims[place] = np.maximum(rims[place], strength * smooth_step(1.0 - np.abs(distance - 1.0) / 0.12))
    return inside, rims


def _slab(rng: np.random.Generator, half: tuple[float, float]) -> Texels:
    """Return one rectangle with straight sides, 0-1; half edges as fractions of the tile."""
    du, dv = offsets(WIDE, (float(rng.random()), float(rng.random())))
    return smooth_step((half[0] - np.abs(du)) / 0.002) * smooth_step((half[1] - np.abs(dv)) / 0.002)
