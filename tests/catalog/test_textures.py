"""The shipped textures; that they are what is painted, tests/catalog/test_bake.py checks."""

import itertools
from functools import cache

import numpy as np
import pytest
import zxingcpp

from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.pictures.draw import PICTURES, code128, draw_picture, with_check_digit
from warehouse_sim.catalog.pictures.sheet import HEIGHT_PX, WIDTH_PX
from warehouse_sim.catalog.textures import DETAIL_OF, DETAILS, TEXTURES, paint, stretch
from warehouse_sim.catalog.textures.tile import NEUTRAL, SIZE, normals
from warehouse_sim.catalog.textures.used import LARGE
from warehouse_sim.catalog.textures.worn import WIDE
from warehouse_sim.errors import ConfigError, UnknownNameError
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


# What a surface shows from near.


def octaves(image: np.ndarray) -> list[float]:
    """Return the contrast that is lost at each halving of an image, as a fraction of its mean; the finest first."""
    lost = []
    while len(image) > 8:
        half = image.reshape(len(image) // 2, 2, len(image) // 2, 2).mean(axis=(1, 3))
        lost.append(float((image - np.kron(half, np.ones((2, 2)))).std() / NEUTRAL))
        image = half
    return lost


@pytest.fixture(params=DETAILS)
def detail_shipped(request: pytest.FixtureRequest) -> TextureImages:
    return read_texture_set(request.param)


def test_every_detail_lies_over_a_texture_and_every_texture_named_exists() -> None:
    named = {name for item in DETAIL_OF.values() for name in (item.name, item.end) if name is not None}
    assert named == set(DETAILS)
    assert set(DETAIL_OF) <= set(TEXTURES)
    assert not set(DETAILS) & set(TEXTURES)


def test_a_detail_changes_neither_colour_nor_gloss_on_average(detail_shipped: TextureImages) -> None:
    for factors in (detail_shipped.albedo, detail_shipped.roughness):
        assert factors is not None
        assert factors.shape == (SIZE, SIZE)
        assert factors.mean() == pytest.approx(NEUTRAL, abs=1.0)
    assert detail_shipped.normal is not None
    lean = (detail_shipped.normal[..., :2].astype(float) - 128.0) / 127.0
    assert np.abs(lean.mean(axis=(0, 1))).max() < 0.005


def test_a_detail_tiles_and_shows_no_repeat(detail_shipped: TextureImages) -> None:
    values = detail_shipped.albedo.astype(float)
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


# Labels hold codes that other people's decoder reads, and a name is one picture.


def read(image: np.ndarray) -> dict[str, str]:
    """Return the texts of the codes in an sRGB image by kind."""
    codes = zxingcpp.read_barcodes(np.ascontiguousarray(image[..., :3]))
    return {code.format.name: code.text.replace("(", "").replace(")", "") for code in codes}


@pytest.mark.parametrize("kind", ["shipping_label", "article_label"])
def test_both_codes_of_a_label_are_read_and_say_the_same(kind: str) -> None:
    seen = set()
    for key in range(12):
        codes = read(draw_picture(f"{kind}:{key}"))
        assert set(codes) == {"Code128", "QRCode"}
        assert codes["QRCode"].startswith(codes["Code128"])
        seen.add(codes["Code128"])
    assert len(seen) == 12


def test_the_number_on_a_shipping_label_has_gs1s_check_digit() -> None:
    """Weighted 3 and 1 from the left of 18 digits, the sum is a multiple of ten."""
    for key in range(5):
        number = read(draw_picture(f"shipping_label:{key}"))["Code128"]
        assert len(number) == 20
        assert number.startswith("00")
        assert sum(int(digit) * (3, 1)[place % 2] for place, digit in enumerate(number[2:])) % 10 == 0


def test_check_digit_of_the_general_specifications_example() -> None:
    assert with_check_digit("37610425002123456") == "376104250021234569"


@pytest.mark.parametrize("key", ["04-012-3", "A-17", "B-03-22-1", "Dock 7"])
def test_a_location_label_is_read_as_its_key(key: str) -> None:
    assert read(draw_picture(f"location_label:{key}"))["Code128"] == key


@pytest.mark.parametrize("kind", PICTURES)
def test_a_name_is_one_picture(kind: str) -> None:
    first, second = draw_picture(f"{kind}:1"), draw_picture(f"{kind}:2")
    draw_picture.cache_clear()
    again = draw_picture(f"{kind}:1")
    assert first.shape == (HEIGHT_PX, WIDTH_PX, 4)
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, second)


def test_ink_on_board_leaves_most_of_it_bare() -> None:
    cover = draw_picture("carton_print:1")[..., 3]
    assert 0.03 < (cover > 127).mean() < 0.5
    assert (draw_picture("shipping_label:1")[..., 3] == 255).all()


def test_what_cannot_be_drawn_is_named() -> None:
    with pytest.raises(UnknownNameError, match="kind of picture"):
        draw_picture("poster:1")
    with pytest.raises(ConfigError, match="printable ASCII"):
        code128("")
