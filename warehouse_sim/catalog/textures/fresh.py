"""Surfaces as they are new: sawn softwood, board, floors, sheet metal, and what is moulded.

Contrast is low where features are large, so that no repeat shows. A tile of wood is three times as long along the grain
as it is wide.
"""

import numpy as np

from warehouse_sim.catalog.noise import (
    Texels,
    displaced,
    grains,
    octaves,
    offsets,
    ridges,
    smooth_step,
    softened,
    strokes,
    value_noise,
)
from warehouse_sim.catalog.textures.tile import SIZE, Tile

STRETCH = 3
"""Length of a tile along the grain, or the pull of film, over its width; the catalog's texture table repeats it."""
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


_FLUTES = 50
"""Flutes in a tile: 8 mm apart in 0.4 m, as in C-flute."""
_SPANGLES = 26
"""Crystals along an edge of a tile: 15 mm each in 0.4 m."""


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
    """Paint stretch film: clear between strands where it is bunched or folded, which its pull lays along u.

    Strands lie in bundles, most of them level, some slanting to the corners of the load.
    """
    level = strokes(rng, SIZE, 330, (40.0, 260.0), (-0.12, 0.12), 0.05)
    slanting = strokes(rng, SIZE, 70, (20.0, 100.0), (-0.7, 0.7), 0.25)
    wide = strokes(rng, SIZE, 90, (50.0, 260.0), (-0.16, 0.16), 0.08)
    wide = np.maximum(np.maximum(wide, 0.7 * np.roll(wide, 1, 0)), 0.5 * np.roll(wide, 2, 0))
    bundles = smooth_step((octaves(rng, SIZE, 2, 4, 3) - 0.42) / 0.22)
    strands = np.maximum(np.maximum(level, wide), 0.8 * slanting)
    strands = strands * strands * (0.12 + 0.88 * bundles)
    clouds, pull = octaves(rng, SIZE, 4, 4, 3), octaves(rng, SIZE, 3, 10, 2)
    albedo = 0.85 + 1.5 * strands + 0.2 * (clouds - 0.5)
    height = softened(1.2 * strands) + 5.0 * pull
    roughness = 1.0 + 0.5 * (clouds - 0.5) + 0.3 * strands
    return Tile(albedo, height, roughness, STRETCH)


def rubber(rng: np.random.Generator) -> Tile:
    """Paint rubber: fine grain, grey abrasion and dust."""
    grain, dust = octaves(rng, SIZE, 160, 160, 2), octaves(rng, SIZE, 6, 6, 5)
    damaged = smooth_step((octaves(rng, SIZE, 40, 48, 3) - 0.5) / 0.35)
    albedo = 1.0 + 0.5 * (dust - 0.5) + 0.25 * (grain - 0.5) + 0.3 * damaged
    height = 0.8 * (grain - 0.5)
    roughness = 1.0 + 0.12 * (dust - 0.5) + 0.10 * (grain - 0.5) + 0.06 * damaged
    return Tile(albedo, height, roughness)
