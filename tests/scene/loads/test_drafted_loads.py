"""Loads of drafted scenes of shipped recipes: what cartons carry, how full layers are, what racks bear."""

import re
from collections import defaultdict
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.scene.raster import Pile, may_carry
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.strength import is_goods
from warehouse_sim.catalog.racks.accessories import MOST_PALLET, load_notice_of
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import sample_scene
from warehouse_sim.schema import SceneSpec

_ON_BEAMS = 0.3
"""Pallets above this height (m) stand on beams."""
FULL = 0.85


SHORT = {"wide_angle": {"bays": 2}, "dock_staging": {"doors": 3}}
"""Fewer bays and doors of the recipes that have many."""


@cache
def drafted(recipe: str, index: int = 1) -> SceneSpec:
    fewer = {"scene": {"layout": SHORT[recipe]}} if recipe in SHORT else None
    return sample_scene(replace(load_recipe(recipe, fewer).scene, observations_per_scene=1), 3, index)


@pytest.mark.parametrize("name", ["industrial", "wide_angle", "dock_staging", "conveyor_pickup"])
def test_no_carton_of_a_scene_carries_more_than_it_can(name: str) -> None:
    scene = drafted(name)
    groups = {item.group for item in scene.instances if item.group}
    heaviest = 0.0
    for group in sorted(groups)[:40]:
        pile = Pile(scene.models, [item for item in scene.instances if item.group == group])
        for number, (model, kg) in enumerate(zip(pile.models, pile.carried(), strict=True)):
            if model.class_name == "carton" and kg > 0.0:
                heaviest = max(heaviest, kg / may_carry(model, pile.across(number)))
    assert 0.1 < heaviest <= 1.0


@pytest.mark.parametrize("recipe", ["industrial", "conveyor_pickup", "wide_angle"])
def test_no_level_bay_or_pallet_weighs_more_than_its_notice_says(recipe: str) -> None:
    scene = drafted(recipe)
    notices = {item.model for item in scene.instances if item.model.startswith("load_notice")}
    assert len(notices) <= 1
    found = re.fullmatch(r"load_notice_(\d+)x(\d+)x(\d+)", "".join(notices))
    assert (found is not None) == (recipe == "wide_angle")
    pallets, bays = _masses(scene)
    assert pallets
    assert max(pallets) <= (int(found[1]) / int(found[3]) if found else MOST_PALLET)
    for levels in bays.values():
        assert found is None or max(levels.values()) <= int(found[1])
        assert found is None or sum(levels.values()) <= int(found[1]) * int(found[2])


def _masses(scene: SceneSpec) -> tuple[list[float], dict[tuple[int, float], dict[float, float]]]:
    """Return the mass of each load on beams, and of the levels of each bay, by place in the row and row (kg)."""
    frames = [item.T_world_object[:2, 3] for item in scene.instances if item.model.startswith("rack_frame")]
    mass: dict[int, float] = defaultdict(float)
    place = {}
    for item in scene.instances:
        model = scene.model_of(item)
        mass[item.group] += model.mass
        if model.class_name == "pallet" and item.group:
            place.setdefault(item.group, item.T_world_object[:3, 3])
    pallets, bays = [], defaultdict(lambda: defaultdict(float))
    for group, (x, y, z) in place.items():
        row = min(frames, key=lambda frame: abs(frame[1] - y))[1]
        if z < _ON_BEAMS or abs(row - y) > 0.3:
            continue
        bay = int(np.searchsorted(sorted(frame[0] for frame in frames if abs(frame[1] - row) < 0.1), x))
        pallets.append(mass[group])
        bays[bay, round(float(row), 1)][round(float(z), 1)] += mass[group]
    return pallets, bays


def test_a_notice_says_what_a_level_a_bay_and_a_pallet_may_weigh() -> None:
    notice, other = load_notice_of(3000, 4, 3), load_notice_of(2400, 4, 3)
    assert notice.name == "load_notice_3000x4x3"
    np.testing.assert_array_equal(notice.size, catalog_object("load_notice").size)
    # Other figures are other strokes: what is written is sampled.
    assert len(notice.mesh().faces) != len(other.mesh().faces)
    assert np.abs(notice.mesh().vertices).max(axis=0) == pytest.approx(notice.size / 2, abs=1e-9)


def layers_of(scene: SceneSpec) -> dict[int, dict[float, float]]:
    """Return for each load of one article the base area (m^2) of its pieces by the height of their tops (m)."""
    loads: dict[int, dict[float, float]] = defaultdict(lambda: defaultdict(float))
    articles: dict[int, set[tuple[float, ...]]] = defaultdict(set)
    for item in scene.instances:
        model = scene.model_of(item)
        if item.dynamic and is_goods(model):
            top = float(item.T_world_object[2, 3] + model.size[2] / 2)
            articles[item.group].add(tuple(model.size))
            loads[item.group][round(top, 2)] += float(np.prod(model.size[:2]))
    return {group: levels for group, levels in loads.items() if len(articles[group]) == 1}


@pytest.mark.parametrize("name", ["block_storage", "dock_staging"])
def test_layers_below_others_and_below_loads_are_full(name: str) -> None:
    """Layers that carry another layer or load have all the pieces of their pattern."""
    assert sum(full_layers(drafted(name, index)) for index in (2, 3)) > 20


def full_layers(scene: SceneSpec) -> int:
    """Return how many layers that bear others or loads are full, all of them."""
    loads = layers_of(scene)
    feet = [
        item.T_world_object[:3, 3] - [0.0, 0.0, scene.model_of(item).size[2] / 2]
        for item in scene.instances
        if scene.model_of(item).class_name == "pallet"
    ]
    centres = {item.group: item.T_world_object[:2, 3] for item in scene.instances}
    below = 0
    for group, levels in loads.items():
        order = sorted(levels)
        under_a_load = any(
            abs(foot[2] - order[-1]) < 0.05 and np.linalg.norm(foot[:2] - centres[group]) < 0.2 for foot in feet
        )
        # A load under another one has no lower layer to hold it against but those of its own pattern.
        for level in order if under_a_load else order[:-1]:
            assert levels[level] >= FULL * max(levels.values()), (group, level)
            below += 1
    return below
