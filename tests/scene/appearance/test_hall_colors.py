"""Colours as a hall shows them: paler than charts, racks in real pairs, one customer's inks; sensors read the same."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog.materials import materials
from warehouse_sim.color import LUMINANCE, linear_from_srgb
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import SceneRecipe, sample_scene
from warehouse_sim.scene.appearance.config import AppearanceConfig
from warehouse_sim.scene.appearance.hall_colors import RACK_PAIRS, in_hall_colors, paled
from warehouse_sim.scene.appearance.surfaces import BEAMS, BOARDS, PRINTS, RACKS, Finish
from warehouse_sim.schema import Material, SceneSpec


def linear(code: str) -> tuple[float, float, float]:
    red, green, blue = linear_from_srgb(np.array([int(code[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0)
    return float(red), float(green), float(blue)


def hall(seed: int, **colors: str) -> dict[str, Material]:
    """The materials of a hall in which catalog materials have been painted."""
    found = {
        name: replace(materials()[name], name=f"{name} x 0", base_color=linear(code)) for name, code in colors.items()
    }
    scene = replace(EMPTY, materials={item.name: item for item in found.values()})
    return in_hall_colors(scene, np.random.default_rng(seed)).materials


PALED = 0.35
EMPTY = SceneSpec(scene_index=0, seed=0, models={}, materials={}, instances=(), lights=(), viewpoints=(), targets=())


def spread(item: Material) -> float:
    return float(np.ptp(item.base_color) / max(item.base_color))


@pytest.fixture(scope="module")
def recipe() -> SceneRecipe:
    return load_recipe("smoke").scene


def test_nothing_but_colours_changes(recipe: SceneRecipe) -> None:
    everyday = replace(recipe, appearance=AppearanceConfig(preset="everyday"))
    scene = sample_scene(everyday, seed=3, scene_index=0)
    again = in_hall_colors(scene, np.random.default_rng(1))
    assert again.instances == scene.instances
    assert again.materials.keys() == scene.materials.keys()
    for name, item in scene.materials.items():
        assert replace(again.materials[name], base_color=item.base_color) == item


def test_recipes_that_do_not_say_how_halls_look_keep_the_catalog_s_colours(recipe: SceneRecipe) -> None:
    scene = sample_scene(recipe, seed=3, scene_index=0)
    assert all(item == materials()[name] for name, item in scene.materials.items() if name in materials())


def test_paint_is_paler_and_as_bright_and_what_must_be_seen_is_not() -> None:
    before = {
        "guard_yellow": "#F7B500",
        "steel_paint_blue": "#123C7C",
        "hivis_orange": "#F2581B",
        "sign_green": "#007A40",
    }
    after = hall(0, **before)
    for name, code in before.items():
        was, now = np.array(linear(code)), np.array(after[f"{name} x 0"].base_color)
        assert LUMINANCE @ now == pytest.approx(LUMINANCE @ was, abs=1e-3)
        kept = name.startswith(("hivis", "sign"))
        left = 1.0 if kept else 0.8 if name.startswith("guard") else 1.0 - PALED
        assert np.ptp(now) == pytest.approx(np.ptp(was) * left, abs=1e-3)
    np.testing.assert_allclose(paled(np.array([0.5, 0.5, 0.5]), PALED), 0.5)


@pytest.mark.parametrize("upright", [item for item in RACKS if not item.bare], ids=lambda item: item.code)
def test_beams_have_a_colour_that_is_sold_with_the_uprights(upright: Finish) -> None:
    (partners,) = (beams for uprights, beams in RACK_PAIRS if upright.code in uprights)
    allowed = [paled(np.array(linear(code)), PALED) for code in partners]
    for seed, beam in enumerate(item for item in BEAMS if not item.bare):
        now = np.array(hall(seed, rack_blue=upright.code, rack_orange=beam.code)["rack_orange x 0"].base_color)
        kept = paled(np.array(linear(beam.code)), PALED)
        changed = np.abs(now - kept).max() > 1e-3
        assert not changed or min(np.abs(now - color).max() for color in allowed) < 1e-3
        # Neither is one hue all over the rack, unless it is grey.
        if min(spread(Material("", linear(code))) for code in (upright.code, beam.code)) > 0.4:
            assert np.abs(now - paled(np.array(linear(upright.code)), PALED)).max() > 0.02


def test_a_customer_prints_two_inks_on_all_cartons_and_board_is_kraft_or_white_mostly() -> None:
    colourful, inks = 0.0, []
    for seed in range(200):
        boards = {
            f"{name}": item.code
            for name, item in zip(("kraft", "kraft_light", "board_white"), BOARDS[7:10], strict=True)
        }
        after = hall(seed, **boards, print_blue=PRINTS[0].code, print_red=PRINTS[1].code, print_green=PRINTS[2].code)
        colourful += sum(spread(after[f"{name} x 0"]) > 0.4 for name in boards) / 3
        inks.append(len({item.base_color for name, item in after.items() if name.startswith("print_")}))
    assert max(inks) == 2
    assert 0.2 < colourful / 200 < 0.4
