"""What a coat of paint, years and dirt make of a material, and what a LiDAR sees of it."""

import numpy as np
import pytest

from warehouse_sim.catalog.materials import materials
from warehouse_sim.color import LUMINANCE, srgb_from_linear
from warehouse_sim.scene.appearance.painting import Look, coated, linear_of
from warehouse_sim.scene.appearance.surfaces import SURFACES, Finish
from warehouse_sim.schema import Material

CATALOG = materials()


def coat(base: str, **changes: object) -> Material:
    plain = {"finish": None, "value": 1.0, "hue_deg": 0.0, "roughness": 1.0, "dirt": 0.0, "texture": None}
    return coated(CATALOG[base], Look(**{**plain, **changes}), "new", CATALOG["galvanised"])  # type: ignore[arg-type]


def test_a_look_without_changes_is_the_material() -> None:
    for name in ("pallet_wood", "kraft", "rack_blue", "stretch_film"):
        was, now = CATALOG[name], coat(name)
        np.testing.assert_allclose(now.base_color, was.base_color, atol=1e-4)
        assert (now.roughness, now.texture, now.opacity) == (was.roughness, was.texture, was.opacity)
        assert now.remission == pytest.approx(was.remission, abs=1e-3)


def test_paint_has_the_colour_of_its_code() -> None:
    now = coat("rack_blue", finish=Finish("#A72920"))
    np.testing.assert_allclose(255 * srgb_from_linear(np.array(now.base_color)), [0xA7, 0x29, 0x20], atol=0.5)
    assert (now.texture, now.metallic) == ("enamel", 0.0)
    assert linear_of("#FFFFFF").tolist() == [1.0, 1.0, 1.0]


def test_bare_steel_is_galvanised() -> None:
    now, zinc = coat("rack_blue", finish=Finish("#BFC1C2", bare=True)), CATALOG["galvanised"]
    assert (now.metallic, now.texture, now.remission) == (zinc.metallic, zinc.texture, pytest.approx(zinc.remission))


def test_dust_greys_and_dulls_and_thick_dirt_stains() -> None:
    clean, dusty, filthy = (coat("guard_yellow", dirt=dirt) for dirt in (0.0, 0.3, 1.0))
    spread = [np.ptp(item.base_color) for item in (clean, dusty, filthy)]
    assert spread[0] > spread[1] > spread[2] > 0.3
    assert clean.roughness < dusty.roughness < filthy.roughness <= 1.0
    assert (clean.texture, dusty.texture, filthy.texture) == ("enamel", "enamel", "steel_worn")
    assert filthy.texture_size == 2 * clean.texture_size
    floor = coat("concrete", dirt=1.0)
    assert (floor.texture, floor.texture_size) == ("concrete_worn", CATALOG["concrete"].texture_size)
    door = coat("door_white", dirt=1.0)
    assert (door.texture, door.texture_size) == (CATALOG["door_white"].texture, CATALOG["door_white"].texture_size)


@pytest.mark.parametrize(
    "name", ["rack_blue", "rack_orange", "guard_yellow", "guard_black", "sign_white", "plastic_red", "plastic_blue",
             "plastic_grey", "truck_red", "truck_orange", "door_white", "steel_grey", "board_white", "sign_green"]
)  # fmt: skip
def test_paint_sends_back_what_the_catalog_s_own_of_that_colour_does(name: str) -> None:
    code = "#" + "".join(f"{round(255 * float(c)):02X}" for c in srgb_from_linear(np.array(CATALOG[name].base_color)))
    assert coat("rack_blue", finish=Finish(code)).remission == pytest.approx(CATALOG[name].remission, abs=0.1)


def test_darker_wood_sends_back_less() -> None:
    was = CATALOG["pallet_wood"].remission
    assert coat("pallet_wood", value=0.25).remission == pytest.approx(was / 2, abs=0.01)


def test_palettes_are_as_bright_as_real_things() -> None:
    """No reflectance of a palette's colour exceeds white paint's, and board is kraft or lighter far more often."""
    for surface in SURFACES.values():
        for finish in surface.palette:
            assert 0.003 < float(LUMINANCE @ linear_of(finish.code)) < 0.93
    board = SURFACES["boards"].palette
    colourful = sum(item.weight for item in board if np.ptp(linear_of(item.code)) / linear_of(item.code).max() > 0.87)
    assert colourful < 0.15 * sum(item.weight for item in board)
