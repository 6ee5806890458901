"""What a surface shows from near."""

import numpy as np
import pytest

from warehouse_sim.catalog.textures import DETAIL_OF, DETAILS, TEXTURES, stretch
from warehouse_sim.catalog.textures.tile import NEUTRAL, SIZE
from warehouse_sim.render.textures import TextureImages, read_texture_set


def octaves(image: np.ndarray) -> list[float]:
    """Return the contrast that is lost at each halving of an image, as a fraction of its mean; the finest first."""
    lost = []
    while len(image) > 8:
        half = image.reshape(len(image) // 2, 2, len(image) // 2, 2).mean(axis=(1, 3))
        lost.append(float((image - np.kron(half, np.ones((2, 2)))).std() / NEUTRAL))
        image = half
    return lost


@pytest.fixture(params=DETAILS)
def shipped(request: pytest.FixtureRequest) -> TextureImages:
    return read_texture_set(request.param)


def test_every_detail_lies_over_a_texture_and_every_texture_named_exists() -> None:
    named = {name for item in DETAIL_OF.values() for name in (item.name, item.end) if name is not None}
    assert named == set(DETAILS)
    assert set(DETAIL_OF) <= set(TEXTURES)
    assert not set(DETAILS) & set(TEXTURES)


def test_a_detail_changes_neither_colour_nor_gloss_on_average(shipped: TextureImages) -> None:
    for factors in (shipped.albedo, shipped.roughness):
        assert factors is not None
        assert factors.shape == (SIZE, SIZE)
        assert factors.mean() == pytest.approx(NEUTRAL, abs=1.0)
    assert shipped.normal is not None
    lean = (shipped.normal[..., :2].astype(float) - 128.0) / 127.0
    assert np.abs(lean.mean(axis=(0, 1))).max() < 0.005


def test_a_detail_tiles_and_shows_no_repeat(shipped: TextureImages) -> None:
    values = shipped.albedo.astype(float)
    for axis in (0, 1):
        steps = np.abs(np.roll(values, -1, axis=axis) - values).mean(axis=1 - axis)
        assert steps[-1] <= steps[:-1].max()
    coarse = values.reshape(4, SIZE // 4, 4, SIZE // 4).mean(axis=(1, 3)) / NEUTRAL
    assert np.abs(coarse - 1.0).max() < 0.1


@pytest.mark.parametrize(("name", "least"), [("detail_concrete", 0.05), ("detail_plaster", 0.03)])
def test_grain_is_as_rough_from_near_as_from_twice_and_eight_times_as_far(name: str, least: float) -> None:
    found = octaves(read_texture_set(name).albedo.astype(float))[:4]
    assert min(found) > least
    assert max(found) < 1.8 * min(found)


@pytest.mark.parametrize("name", ["detail_coating", "detail_zinc"])
def test_paint_and_metal_have_no_clouds(name: str) -> None:
    assert max(octaves(read_texture_set(name).albedo.astype(float))[4:]) < 0.01


def test_grain_of_wood_runs_along_u_and_is_longer_than_wide() -> None:
    pixels = read_texture_set("detail_wood").albedo.astype(float)
    along_u, along_v = (np.abs(np.diff(pixels, axis=axis)).mean() for axis in (1, 0))
    assert along_v > 2.0 * along_u
    assert stretch("detail_wood") == 3
    assert stretch("detail_wood_end") == 1
