"""Load notices are held against what stands on each level and in each bay of drafted scenes."""

import re
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.racks.accessories import MOST_PALLET, load_notice_of
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import sample_scene
from warehouse_sim.schema import SceneSpec

_ON_BEAMS = 0.3
"""Pallets above this height (m) stand on beams."""


@pytest.mark.parametrize("recipe", ["mezzanine", "mixed_pallets", "conveyor_pickup", "wide_angle"])
def test_no_level_bay_or_pallet_weighs_more_than_its_notice_says(recipe: str) -> None:
    loaded = load_recipe(recipe).scene
    scene = sample_scene(replace(loaded, observations_per_scene=1), seed=5, scene_index=0)
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
