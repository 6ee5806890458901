"""What a surface shows from near: grain of 1-30 mm, laid over its texture in the same way wherever that is even.

Contrast is as strong in each octave as in the next, as photographs of concrete have it (2-3 % each; no source: a
prior), so that an image from near and one from afar is as rough; nothing is wider than an eighth of a tile.
"""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.noise import Texels, displaced, grains, octaves, smooth_step, softened, strokes, value_noise
from warehouse_sim.catalog.textures.tile import SIZE, Tile

DETAIL_STRETCH = 3
"""Length of a tile of grain of wood along the grain over its width."""
_FLUTES = 32
"""Flutes of board in a tile: 8 mm apart in 0.256 m, as in C-flute."""


@dataclass(frozen=True)
class Detail:
    """Which detail lies over a texture."""

    name: str
    """Of the detail."""
    size: float
    """Edge of its tile across the grain (m)."""
    end: str | None = None
    """The detail of faces across the grain; None where they look as all others."""


def detail_concrete(rng: np.random.Generator) -> Tile:
    """Paint trowelled mortar: sand, aggregate that shows through, pores, crazing as fine as a hair."""
    fine = _rough(rng, (8, 16, 32, 64, 128, 256), (0.2, 0.4, 0.8, 1.4, 1.8, 2.1))
    sand = value_noise(rng, SIZE, SIZE, SIZE) - 0.5
    owner, near, _ = grains(rng, SIZE, 56)
    tone, shown = rng.random((2, 56 * 56))
    stones = smooth_step((0.16 * (shown[owner] - 0.35) - near) / 0.05) * (tone[owner] - 0.5)
    owner, near, _ = grains(rng, SIZE, 48)
    pores = smooth_step((0.10 * (rng.random(48 * 48)[owner] - 0.6) - near) / 0.012)
    cracks = _crazing(rng, 9)
    albedo = 1.0 + 0.31 * fine + 0.28 * sand + 0.26 * stones - 0.40 * pores - 0.16 * cracks
    height = 0.5 * fine + 0.25 * sand - 0.9 * pores - 0.3 * cracks
    return Tile(albedo, height, 1.0 + 0.35 * fine - 0.2 * stones + 0.2 * pores)


def detail_plaster(rng: np.random.Generator) -> Tile:
    """Paint a rolled or cast wall: the stipple of the roller, pinholes, dust on what stands out."""
    stipple = softened(octaves(rng, SIZE, 90, 90, 2)) - 0.5
    fine = _rough(rng, (16, 32, 64, 128, 256), (0.3, 0.5, 0.8, 1.1, 1.2))
    owner, near, _ = grains(rng, SIZE, 40)
    holes = smooth_step((0.06 * (rng.random(40 * 40)[owner] - 0.75) - near) / 0.008)
    albedo = 1.0 + 0.32 * fine + 0.2 * stipple - 0.30 * holes
    return Tile(albedo, 1.1 * stipple + 0.2 * fine - 0.8 * holes, 1.0 + 0.2 * stipple + 0.1 * fine)


def detail_board(rng: np.random.Generator) -> Tile:
    """Paint liner of board: flutes along v, fibres in all directions, shives and specks, clouds of the pulp."""
    fibres = strokes(rng, SIZE, 3000, (4.0, 18.0), (-1.0, 1.0), 3.0)
    fibres = fibres + strokes(rng, SIZE, 3000, (4.0, 18.0), (-1.0, 1.0), 3.0).T
    shives = strokes(rng, SIZE, 260, (3.0, 9.0), (-1.0, 1.0), 1.0) + strokes(rng, SIZE, 260, (3.0, 9.0), (-1.0, 1.0)).T
    pulp = _rough(rng, (16, 32, 64, 128, 256), (0.5, 0.7, 1.0, 1.2, 1.4))
    place = (np.arange(SIZE) + 0.5) * (_FLUTES / SIZE)
    fraction = place - np.floor(place)
    flutes = smooth_step(2.0 * np.minimum(fraction, 1.0 - fraction))[None, :] * (
        0.6 + 0.8 * octaves(rng, SIZE, 8, 8, 2)
    )
    albedo = 1.0 + 0.16 * pulp - 0.10 * fibres - 0.22 * shives - 0.05 * (flutes - 0.5)
    return Tile(albedo, 0.35 * flutes + 0.10 * fibres + 0.15 * pulp, 1.0 + 0.1 * pulp - 0.06 * flutes)


def detail_wood(rng: np.random.Generator) -> Tile:
    """Paint sawn softwood: fibres and rays along u, pores, fuzz that the saw tore, hairline splits."""
    fibres = octaves(rng, SIZE, 12, 128, 2) - 0.5
    lines = 0.6 * (value_noise(rng, SIZE, 10, 256) - 0.5) + 0.5 * (value_noise(rng, SIZE, 24, SIZE) - 0.5)
    bands = value_noise(rng, SIZE, 4, 40) - 0.5
    pores = strokes(rng, SIZE, 2600, (4.0, 20.0), (-0.04, 0.04))
    splits = strokes(rng, SIZE, 26, (30.0, 120.0), (-0.02, 0.02), 0.02)
    fuzz = strokes(rng, SIZE, 700, (4.0, 16.0), (-0.5, 0.5), 0.6)
    dots = value_noise(rng, SIZE, 256, 256) - 0.5
    albedo = 1.0 + 0.30 * fibres + 0.24 * lines + 0.12 * bands + 0.08 * dots - 0.13 * pores - 0.5 * splits + 0.07 * fuzz
    height = 1.0 * fibres + 0.7 * lines - 0.4 * pores - 1.2 * splits + 0.3 * fuzz
    return Tile(albedo, height, 1.0 + 0.2 * fibres - 0.06 * fuzz, DETAIL_STRETCH)


def detail_wood_end(rng: np.random.Generator) -> Tile:
    """Paint sawn ends of wood: rings cut across, checks along the rays, dark where water stood, saw marks."""
    way = 20.0 * (octaves(rng, SIZE, 3, 2, 3) - 0.5)
    place = 34.0 * (np.arange(SIZE)[:, None] + 0.5) / SIZE + 2.6 * (octaves(rng, SIZE, 2, 1, 3) - 0.5) * 4.0
    phase = place - np.floor(place)
    late = smooth_step((phase - 0.2) / 0.65) * smooth_step((1.0 - phase) / 0.15)
    rays = displaced(strokes(rng, SIZE, 34, (40.0, 200.0), (-0.12, 0.12), 0.1).T, way, way.T)
    saw = value_noise(rng, SIZE, 150, 5) - 0.5
    dirt = octaves(rng, SIZE, 8, 8, 5) - 0.5
    dots = value_noise(rng, SIZE, 256, 256) - 0.5
    albedo = 1.0 - 0.20 * late - 0.5 * rays + 0.10 * saw + 0.55 * dirt + 0.14 * dots
    return Tile(albedo, 0.3 * late - 1.2 * rays + 0.8 * saw + 0.3 * dots, 1.0 + 0.15 * dirt)


def detail_coating(rng: np.random.Generator) -> Tile:
    """Paint powder coat and moulded skin: orange peel of 2-3 mm, grit, hair scratches; no clouds."""
    peel = softened(octaves(rng, SIZE, 100, 100, 1)) - 0.5
    grit = value_noise(rng, SIZE, 256, 256) - 0.5
    scratches = strokes(rng, SIZE, 60, (20.0, 120.0), (-0.5, 0.5), 0.2)
    owner, near, _ = grains(rng, SIZE, 40)
    specks = smooth_step((0.03 * (rng.random(40 * 40)[owner] - 0.85) / 0.15 - near) / 0.006)
    albedo = 1.0 + 0.05 * peel + 0.07 * grit + 0.07 * scratches - 0.16 * specks
    return Tile(albedo, 0.7 * peel + 0.1 * grit - 0.2 * scratches, 1.0 + 0.1 * grit + 0.3 * scratches + 0.3 * specks)


def detail_zinc(rng: np.random.Generator) -> Tile:
    """Paint zinc and bare sheet: brushed lines along u, feathers of the crystals, white rust in dots."""
    lines = 0.5 * value_noise(rng, SIZE, 8, 200) + 0.5 * value_noise(rng, SIZE, 14, SIZE) - 0.5
    feathers = octaves(rng, SIZE, 90, 90, 2) - 0.5
    owner, near, _ = grains(rng, SIZE, 44)
    dots = smooth_step((0.05 * (rng.random(44 * 44)[owner] - 0.8) / 0.2 - near) / 0.01)
    scratches = strokes(rng, SIZE, 50, (20.0, 200.0), (-0.3, 0.3))
    albedo = 1.0 + 0.20 * lines + 0.10 * feathers + 0.14 * dots + 0.10 * scratches
    return Tile(
        albedo, 0.4 * lines + 0.15 * feathers - 0.2 * scratches, 1.0 + 0.5 * lines + 0.3 * feathers + 0.3 * dots
    )


def _rough(rng: np.random.Generator, cells: tuple[int, ...], weights: tuple[float, ...]) -> Texels:
    """Return a sum of noises about 0, one for each number of ``cells`` along an edge, each of its own strength."""
    total = np.zeros((SIZE, SIZE))
    for number, weight in zip(cells, weights, strict=True):
        total += weight * (value_noise(rng, SIZE, number, number) - 0.5)
    return total


def _crazing(rng: np.random.Generator, cells: int) -> Texels:
    """Return the borders of cells of random shape, as what dries cracks, here and there; 0-1."""
    _, near, far = grains(rng, SIZE, cells)
    way = 10.0 * (octaves(rng, SIZE, 16, 16, 4) - 0.5)
    lines = smooth_step(1.0 - (np.sqrt(far) - np.sqrt(near)) / 0.035)
    return displaced(lines, way, way.T) * smooth_step((octaves(rng, SIZE, 4, 4, 2) - 0.45) / 0.15)
