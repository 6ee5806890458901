"""Clutter stands on the floor, clear of all, and takes nothing from what is sampled beside it."""

import logging
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.errors import PlacementError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.physics.check import contact_state
from warehouse_sim.scene import Distribution, sample_scene
from warehouse_sim.scene.clutter import ClutterConfig, add_clutter, clutter_shelves
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.hand_made import cleared, empty_scene, is_loose, with_object, with_replaced
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import Layout
from warehouse_sim.scene.layouts.small_parts import SmallPartsConfig
from warehouse_sim.scene.loads.resting import drop_to_rest
from warehouse_sim.schema import SceneSpec


@pytest.mark.parametrize("seed", range(3))
def test_all_stand_on_the_floor_and_clear_of_everything(seed: int) -> None:
    draft, site = built(RackAisleConfig(guards=True))
    before, others = len(draft.instances), draft.solids()
    add_clutter(draft, ClutterConfig(Distribution.constant(30)), site.aisle, np.random.default_rng(seed))
    added = draft.instances[before:]
    assert len(added) == 30
    assert len(Counter(item.model for item in added)) > 8
    boxes = BoxStack.of([OrientedBox(item.T_world_object, draft.models[item.model].size) for item in added])
    pairs = np.array([(a, b) for a in range(len(added)) for b in range(a)])
    assert boxes.separation(boxes, pairs).distance.min() >= 0.05 - 1e-9
    _, top = others.extents
    standing = others.boxes.subset(top[:, 2] > 0.011)
    assert all(
        standing.clear_of(OrientedBox(item.T_world_object, draft.models[item.model].size), 0.05) for item in added
    )
    np.testing.assert_allclose(boxes.extents()[0][:, 2], 0.0, atol=1e-9)
    y = np.array([item.T_world_object[1, 3] for item in added])
    assert (np.minimum(y - site.aisle.y_min, site.aisle.y_max - y) < 0.9).mean() > 0.6


def test_a_full_floor_takes_what_it_can() -> None:
    draft = SceneDraft()
    add_clutter(draft, ClutterConfig(Distribution.constant(60)), Area(0.0, 1.5, 0.0, 1.5), np.random.default_rng(0))
    assert 0 < len(draft.instances) < 12


def test_it_moves_nothing_else() -> None:
    recipe = load_recipe("smoke").scene
    bare = sample_scene(recipe, 0, 0)
    full = sample_scene(replace(recipe, clutter=ClutterConfig(Distribution.constant(8))), 0, 0)
    assert sum(full.model_of(item).class_name == "clutter" for item in full.instances) == 8
    for a, b in zip(bare.instances, full.instances, strict=False):
        assert a.model == b.model
        assert np.array_equal(a.T_world_object, b.T_world_object)


SHELVES: tuple[Layout, ...] = (
    SmallPartsConfig(bays=4, rows=2, fill=0.7),
    RackAisleConfig(beams="step", mesh_decks=True, bays=3),
)


@pytest.mark.parametrize("layout", SHELVES, ids=lambda layout: layout.kind)
def test_clutter_on_shelves_rests_there_and_touches_nothing_else(layout: Layout) -> None:
    draft, site = built(layout)
    before = len(draft.instances)
    config = ClutterConfig(on_shelves=Distribution.constant(12))
    clutter_shelves(draft, config, site.strips, np.random.default_rng(1))
    added = draft.instances[before:]
    assert len(added) >= 6
    solids = draft.solids()
    for item in added:
        assert draft.models[item.model].class_name == "clutter"
        mine = solids.of_objects([item.instance_id])
        near = solids.near(*solids.extent_of([item.instance_id]), 0.05) & ~mine
        assert drop_to_rest(solids.boxes.subset(mine), solids.boxes.subset(near)) == pytest.approx(0.0, abs=1e-6)
        pairs = solids.boxes.subset(mine).pairs(solids.boxes.subset(near), 0.0)
        deep = solids.boxes.subset(mine).separation(solids.boxes.subset(near), pairs).distance
        assert deep.min(initial=0.0) > -1e-6


def scene_of(*objects: tuple[str, float, float]) -> SceneSpec:
    scene = empty_scene(0)
    for name, x, y in objects:
        scene = with_object(scene, name, x, y, None, 0.0)
    return scene


def shift(before: SceneSpec, after: SceneSpec, number: int) -> np.ndarray:
    return after.instances[number].T_world_object[:3, 3] - before.instances[number].T_world_object[:3, 3]


def test_what_is_clear_stays() -> None:
    scene = scene_of(("epal1", 0.0, 0.0), ("epal1", 1.3, 0.0), ("carton_600x400x300", 0.0, 0.0))
    assert cleared(scene).instances == scene.instances


def test_the_later_load_gives_way_by_the_shortest_way_with_all_that_stands_on_it(
    caplog: pytest.LogCaptureFixture,
) -> None:
    scene = scene_of(("epal1", 0.0, 0.0))
    scene = with_object(scene, "epal1", 1.1, 0.0, 0.0725, 0.0)
    scene = with_object(scene, "carton_600x400x300", 1.1, 0.0, None, 0.0)
    with caplog.at_level(logging.WARNING):
        after = cleared(scene)
    np.testing.assert_array_equal(shift(scene, after, -3), np.zeros(3))
    np.testing.assert_allclose(shift(scene, after, -2), [0.1, 0.0, 0.0], atol=0.021)
    np.testing.assert_array_equal(shift(scene, after, -1), shift(scene, after, -2))
    assert contact_state(after).problems(2.1, 1.0) == []
    assert "epal1 (object" in caplog.text
    assert caplog.text.count("was moved") == 1


def test_what_has_no_free_place_is_an_error() -> None:
    in_the_floor = with_object(empty_scene(0), "epal1", 0.0, 0.0, 0.02, 0.0)
    with pytest.raises(PlacementError, match=r"epal1 .* overlaps .* put it elsewhere"):
        cleared(in_the_floor)


def test_what_replaces_stands_on_the_same_ground() -> None:
    scene = scene_of(("epal1", 0.0, 0.0), ("carton_600x400x300", 0.0, 0.0))
    after, count = with_replaced(scene, "carton_600x400x300", "carton_400x300x200")
    assert count == 1
    np.testing.assert_allclose(shift(scene, after, -1), [0.0, 0.0, -0.05], atol=1e-12)
    assert "carton_600x400x300" not in after.models
    assert after.instances[-1].group == scene.instances[-2].group


@pytest.mark.parametrize(
    ("name", "loose"),
    [("epal1", True), ("carton_600x400x300", True), ("shelf_bay", False), ("forklift", False), ("cone_500", True),
     ("person_tall_standing", False), ("wall", False)],
)  # fmt: skip
def test_what_people_set_down_is_loose(name: str, loose: bool) -> None:
    scene = scene_of((name, 0.0, 0.0))
    assert is_loose(scene.model_of(scene.instances[-1])) is loose
    assert scene.instances[-1].dynamic is loose
