"""Paint is sampled by kind of surface: what shares a look in the world shares it here, and nothing else changes."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from warehouse_sim.catalog.materials import materials
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import SceneRecipe, sample_scene, scene_rng
from warehouse_sim.scene.appearance.config import AppearanceConfig, PaintConfig
from warehouse_sim.scene.appearance.painting import paint_scene
from warehouse_sim.scene.appearance.surfaces import SURFACES
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.schema import SceneSpec

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
