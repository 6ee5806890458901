"""The shipped textures; that they are what is painted, tests/catalog/test_bake.py checks."""

import itertools
from functools import cache

import numpy as np
import pytest

from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.textures import TEXTURES, paint, stretch
from warehouse_sim.catalog.textures.tile import NEUTRAL, SIZE, normals
from warehouse_sim.catalog.textures.used import LARGE
from warehouse_sim.catalog.textures.worn import WIDE
from warehouse_sim.render.textures import TextureImages, read_texture_set

QUICKLY_PAINTED = ("wood", "brushed", "plastic_worn", "blockwork", "enamel")
"""Of each module of painters; all are compared by the slow test."""


@cache
def shipped(name: str) -> TextureImages:
    return read_texture_set(name)


def edge(name: str) -> int:
    if name in ("slab", "coat", "precast"):
        return LARGE
    return WIDE if name.endswith("_worn") else SIZE


def unit_normals(name: str) -> np.ndarray:
    return (shipped(name).normal.astype(float) - 128.0) / 127.0


@pytest.mark.parametrize("name", QUICKLY_PAINTED)
def test_what_is_painted_is_what_is_shipped(name: str) -> None:
    images = shipped(name)
    for kind, pixels in paint(name).images().items():
        assert np.array_equal(pixels, getattr(images, kind)), kind


@pytest.mark.parametrize("name", TEXTURES)
def test_factors_are_neutral_on_average_and_vary(name: str) -> None:
    for factors in (shipped(name).albedo, shipped(name).roughness):
        assert factors.shape == (edge(name), edge(name))
        assert factors.dtype == np.uint8
        assert factors.mean() == pytest.approx(NEUTRAL, abs=1.0)
        assert 1.5 < factors.std() < 30.0


@pytest.mark.parametrize("name", TEXTURES)
def test_normals_are_unit_vectors_that_lean_nowhere_on_average(name: str) -> None:
    vectors = unit_normals(name)
    assert vectors.shape == (edge(name), edge(name), 3)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=-1), 1.0, atol=0.01)
    assert np.abs(vectors[..., :2].mean(axis=(0, 1))).max() < 0.005
    assert vectors[..., 2].min() > 0.4
    assert vectors[..., :2].std() > 0.005


def test_a_texture_tiles_without_a_seam() -> None:
    for name, axis in itertools.product(TEXTURES, [0, 1]):
        images = shipped(name)
        for pixels in (images.albedo, images.normal, images.roughness):
            values = pixels.astype(float).reshape(edge(name), edge(name), -1)
            steps = np.abs(np.roll(values, -1, axis=axis) - values).mean(axis=(1 - axis, 2))
            assert steps[-1] <= steps[:-1].max(), (name, axis)


def test_no_repeat_shows_from_afar() -> None:
    """Where a tile is a few pixels wide, it is nearly even: a floor or a wall shows no chequers."""
    for name in TEXTURES:
        coarse = shipped(name).albedo.astype(float).reshape(4, edge(name) // 4, 4, edge(name) // 4).mean(axis=(1, 3))
        assert np.abs(coarse / NEUTRAL - 1.0).max() < 0.1, name


def test_a_ramp_leans_against_its_rise_in_opengls_way() -> None:
    """Heights that grow to the right and up the image: red and green fall below the middle."""
    up, right = -np.arange(SIZE, dtype=float)[:, None], np.arange(SIZE, dtype=float)[None, :]
    across = np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0)
    for height, lean in ((0.0 * up + right, across * [-1, 0, 1]), (up + 0.0 * right, across[[1, 0, 2]] * [0, -1, 1])):
        inner = normals(height)[10:-10, 10:-10].reshape(-1, 3)
        assert (inner == np.round(lean * 127.0) + 128.0).all()
    along_grain = normals(0.0 * up + right, stretch=3)[10, 10]
    assert along_grain.tolist() == [88, 128, 248]  # a slope of 1 in 3


@pytest.mark.parametrize("name", ["wood", "brushed"])
def test_grain_runs_along_u(name: str) -> None:
    pixels = shipped(name).albedo.astype(float)
    along_u, along_v = (np.abs(np.diff(pixels, axis=axis)).mean() for axis in (1, 0))
    assert along_v > 2.0 * along_u


def test_flutes_of_board_run_along_v() -> None:
    """The relief of kraft repeats fifty times along u, and along v it does not."""
    across, along = (np.abs(np.fft.rfft(unit_normals("kraft")[..., 0].mean(axis=axis))) for axis in (0, 1))
    assert across[1:].argmax() + 1 == 50
    assert along[50] < 0.1 * across[50]


def test_wood_is_stretched_and_every_texture_is_used_or_offered() -> None:
    assert stretch("wood") == 3
    assert stretch("concrete") == 1
    assert stretch("wood_worn") == stretch("wood")
    assert {item.texture for item in materials().values() if item.texture} <= set(TEXTURES)


@pytest.mark.parametrize("name", [name for name in TEXTURES if name.endswith("_worn")])
def test_a_damaged_surface_is_the_fresh_one_with_marks_as_large_as_life(name: str) -> None:
    """It is twice as wide at the same grain: as much fine detail a texel, more that is coarse, no quarter twice."""
    fresh, damaged = (shipped(item).albedo.astype(float) for item in (name.removesuffix("_worn"), name))
    assert damaged.shape == (1024, 1024)
    fine = [np.diff(image, axis=1).std() for image in (fresh, damaged)]
    assert fine[1] > 0.8 * fine[0]
    coarse = [image.reshape(len(image) // 16, 16, -1, 16).mean(axis=(1, 3)).std() for image in (fresh, damaged)]
    assert coarse[1] > 1.15 * coarse[0]
    quarters = damaged.reshape(2, 512, 2, 512).swapaxes(1, 2).reshape(4, -1)
    assert (np.corrcoef(quarters) - np.eye(4)).max() < 0.97


@pytest.mark.parametrize(
    "name", ["slab", "coat", "precast", "blockwork", "liner", "enamel", "concrete_worn", "epoxy_worn"]
)
@pytest.mark.parametrize("texels", [1, 2, 4, 8])
def test_used_surfaces_are_uneven_from_near_and_from_afar(name: str, texels: int) -> None:
    """In 16 x 16 pixels of ``texels`` texels each nearly no part is even to 2 %, as no wall in use is."""
    image = shipped(name).albedo.astype(float)
    seen = image.reshape(edge(name) // texels, texels, edge(name) // texels, texels).mean(axis=(1, 3))
    count = len(seen) // 16
    blocks = seen.reshape(count, 16, count, 16).std(axis=(1, 3)) / NEUTRAL
    assert (blocks < 0.02).mean() < 0.05
