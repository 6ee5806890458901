"""Paint is sampled by kind of surface: what shares a look in the world shares it here, and nothing else changes."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from warehouse_sim.catalog.materials import materials
from warehouse_sim.color import LUMINANCE, linear_from_srgb, srgb_from_linear
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import SceneRecipe, sample_scene, scene_rng
from warehouse_sim.scene.appearance.config import AppearanceConfig, PaintConfig
from warehouse_sim.scene.appearance.hall_colors import RACK_PAIRS, in_hall_colors, paled
from warehouse_sim.scene.appearance.painting import Look, coated, linear_of, paint_scene
from warehouse_sim.scene.appearance.surfaces import BEAMS, BOARDS, PRINTS, RACKS, SURFACES, Finish
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.schema import Material, SceneSpec

ALL_NEW = PaintConfig(fraction=1.0)
WILD = PaintConfig(fraction=1.0, any_hue=1.0, dirt=Distribution.uniform(0.0, 1.0), swap=0.5)
SHIFTED = PaintConfig(value=Distribution.uniform(0.4, 1.4), hue_deg=Distribution.uniform(-20.0, 20.0))


@pytest.fixture(scope="module")
def plain() -> SceneSpec:
    return sample_scene(load_recipe("smoke").scene, seed=3, scene_index=0)


def painted(scene: SceneSpec, **settings: PaintConfig) -> SceneSpec:
    return paint_scene(scene, AppearanceConfig(**settings), partial(scene_rng, scene.seed, scene.scene_index))


def of_class(scene: SceneSpec, name: str) -> list:
    return [item for item in scene.instances if scene.model_of(item).class_name == name]


def test_nothing_is_painted_unless_requested_for(plain: SceneSpec) -> None:
    assert painted(plain).instances == plain.instances
    assert SceneRecipe().appearance.resolved() == {}
    assert not any(item.paint for item in plain.instances)


def test_only_paint_changes_and_every_name_is_there(plain: SceneSpec) -> None:
    after = painted(plain, **dict.fromkeys(SURFACES, WILD))
    for a, b in zip(plain.instances, after.instances, strict=True):
        assert (a.instance_id, a.model, a.dynamic, a.group) == (b.instance_id, b.model, b.dynamic, b.group)
        assert np.array_equal(a.T_world_object, b.T_world_object)
        assert set(b.paint) <= {part.material for part in plain.model_of(a).parts}
        assert set(b.paint.values()) <= set(after.materials)
    assert {name: after.materials[name] for name in plain.materials} == plain.materials
    for name in after.materials.keys() - plain.materials.keys():
        item = after.materials[name]
        assert item.name == name
        assert all(0.0 < channel <= 0.9 for channel in item.base_color)
        assert 0.0 < item.roughness <= 1.0
        assert 0.0 < item.remission <= 2.0


def test_a_hall_has_one_make_of_rack(plain: SceneSpec) -> None:
    after = painted(plain, racks=ALL_NEW, beams=ALL_NEW)
    for material in ("rack_blue", "rack_orange"):
        used = {item.paint[material] for item in of_class(after, "rack") if material in item.paint}
        assert len(used) == 1
        assert after.materials[used.pop()].base_color != materials()[material].base_color


def test_cartons_of_one_article_in_one_load_share_their_board_and_pallets_differ(plain: SceneSpec) -> None:
    after = painted(plain, boards=ALL_NEW, pallets=SHIFTED)
    boards: dict[object, set[tuple[str, ...]]] = {}
    for item in of_class(after, "carton"):
        boards.setdefault((item.group, item.model), set()).add(tuple(item.paint.values()))
    assert len(boards) > 2
    assert all(len(found) == 1 for found in boards.values())
    assert len({tuple(found) for found in boards.values()}) > 1
    pallets = of_class(after, "pallet")
    assert len({tuple(sorted(item.paint.values())) for item in pallets}) > 1


def test_one_more_surface_moves_no_other(plain: SceneSpec) -> None:
    alone, both = painted(plain, boards=ALL_NEW), painted(plain, boards=ALL_NEW, tape=ALL_NEW, racks=WILD)
    for a, b in zip(of_class(alone, "carton"), of_class(both, "carton"), strict=True):
        assert a.paint.items() <= b.paint.items()
        assert all(alone.materials[name] == both.materials[name] for name in a.paint.values())


def test_common_colours_are_the_palette_s_and_their_shares_are_the_weights(plain: SceneSpec) -> None:
    counts: dict[tuple[float, ...], int] = {}
    for index in range(300):
        after = paint_scene(plain, AppearanceConfig(beams=ALL_NEW), partial(scene_rng, 5, index))
        (color,) = {
            after.materials[item.paint["rack_orange"]].base_color
            for item in after.instances
            if "rack_orange" in item.paint
        }
        counts[color] = counts.get(color, 0) + 1
    palette = SURFACES["beams"].palette
    assert len(counts) == len(palette)
    most = max(palette, key=lambda finish: finish.weight)
    expected = 300 * most.weight / sum(finish.weight for finish in palette)
    assert max(counts.values()) == pytest.approx(expected, abs=4 * np.sqrt(expected))


def test_materials_stay_few_and_what_is_left_shares_them(plain: SceneSpec, monkeypatch: pytest.MonkeyPatch) -> None:
    most = len(plain.materials) + 5
    monkeypatch.setattr("warehouse_sim.scene.appearance.painting.MOST_MATERIALS", most)
    after = painted(plain, **dict.fromkeys(SURFACES, WILD))
    assert len(after.materials) == most
    assert all(name in after.materials for item in after.instances for name in item.paint.values())


def test_film_stays_film() -> None:
    recipe = load_recipe("smoke").scene
    scene = sample_scene(replace(recipe, loads=replace(recipe.loads, wrap_fraction=1.0)), seed=3, scene_index=0)
    after = painted(scene, film=WILD)
    wraps = [item for item in of_class(after, "wrap") if item.paint]
    assert wraps
    assert all(after.materials[name].opacity < 1.0 for item in wraps for name in item.paint.values())


def test_a_preset_is_what_is_not_said_otherwise() -> None:
    assert AppearanceConfig(preset="everyday").resolved().keys() == SURFACES.keys()
    own = AppearanceConfig(preset="everyday", racks=PaintConfig(), beams=ALL_NEW).resolved()
    assert "racks" not in own
    assert own["beams"] == ALL_NEW


def test_a_recipe_reads_its_appearance() -> None:
    recipe = SceneRecipe.from_plain({"appearance": {"racks": {"fraction": {"min": 0.2, "max": 0.4}}}}, "here")
    sampled = recipe.sampled(partial(scene_rng, 0, 0))
    assert sampled.appearance.racks is not None
    assert 0.2 <= sampled.appearance.racks.fraction <= 0.4
    with pytest.raises(ConfigError, match=r"dirt must stay within 0-1"):
        SceneRecipe.from_plain({"appearance": {"racks": {"dirt": {"min": 0.5, "max": 1.5}}}}, "here")
    with pytest.raises(ConfigError, match=r"preset must be one of 'catalog', 'everyday', 'wild'"):
        SceneRecipe.from_plain({"appearance": {"preset": "odd"}}, "here")


def test_smooth_surfaces_have_other_textures_and_nothing_else(plain: SceneSpec) -> None:
    after = paint_scene(plain, AppearanceConfig(surfaces="smooth"), partial(scene_rng, 3, 0))
    assert after.instances == plain.instances
    assert plain.materials["concrete"].texture == "slab"
    assert (after.materials["concrete"].texture, after.materials["concrete"].texture_size) == ("concrete", 3.0)
    for name, item in plain.materials.items():
        like = replace(after.materials[name], texture=item.texture, texture_size=item.texture_size)
        assert like == item


def test_the_frozen_recipe_has_smooth_surfaces() -> None:
    scene = sample_scene(load_recipe("industrial-v1").scene, seed=0, scene_index=0)
    assert {scene.materials[name].texture for name in ("concrete", "wall_paint", "kraft", "rack_blue")} == {
        "concrete", "plastic", "kraft", "steel"
    }  # fmt: skip


# What a coat of paint, years and dirt make of a material, and what a LiDAR sees of it.


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


# Colours as a hall shows them: paler than charts, racks in real pairs, one customer's inks; sensors read the same.


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
