"""Clutter stands on the floor, clear of all, and takes nothing from what is sampled beside it."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene import Distribution, sample_scene
from warehouse_sim.scene.clutter import ClutterConfig, add_clutter, clutter_shelves
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import Layout
from warehouse_sim.scene.layouts.small_parts import SmallPartsConfig
from warehouse_sim.scene.loads.resting import drop_to_rest


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
