"""Drive-in racks: pallets span the lane and lie on both rails; lanes are filled from their far end."""

from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.physics import settle_scene
from warehouse_sim.scene.layouts.drive_in import DriveInConfig
from warehouse_sim.scene.sampling import sample_scene


def test_slots_lie_on_the_rails_of_both_sides() -> None:
    layout = DriveInConfig(lanes=2, lane_depth=3, levels=3, level_pitch=1.5)
    draft, site = built(layout)
    assert len(site.slots) == 2 * 3 * 3
    solids = draft.solids()
    rails = solids.of_objects([item.instance_id for item in draft.instances if item.model == "drive_in_rail"])
    boxes = solids.boxes.subset(rails)
    tops = boxes.centre[:, 2] + boxes.half[:, 2]
    for slot in site.slots:
        x, y, z = slot.T_world_slot[:3, 3]
        under = (np.abs(tops - z) < 1e-9) & (np.abs(boxes.centre[:, 1] - y) < 0.01)
        reach = np.abs(boxes.centre[under, 0] - x) - boxes.half[under, 0]
        # 1.2 m of pallet, 1.35 m of lane: each end lies 80-100 mm on its rail.
        lying = np.sort(reach)[:2]
        assert z == 0.0 or np.all((lying > 0.6 - 0.1) & (lying < 0.6 - 0.08))


def test_it_is_as_high_as_the_roof_allows() -> None:
    for roof, levels in ((True, 3), (False, 4)):
        _, site = built(DriveInConfig(levels=5, level_pitch=1.9), roof=roof)
        assert len({round(float(slot.T_world_slot[2, 3]), 3) for slot in site.slots}) == levels


def test_lanes_are_filled_from_the_far_end_and_stand() -> None:
    recipe = load_recipe("drive_in")
    drawn = replace(recipe.scene, layout=DriveInConfig(lanes=2, lane_depth=3), observations_per_scene=1)
    scene = sample_scene(drawn, seed=0, scene_index=1)
    settled, report = settle_scene(scene, recipe.settle)
    assert report.problems == ()
    pallets = [item for item in settled.instances if settled.model_of(item).class_name == "pallet" and item.dynamic]
    racked = [item for item in pallets if item.T_world_object[1, 3] > 0]

    def lane(item: object) -> tuple[float, float]:
        x, _, z = item.T_world_object[:3, 3]  # type: ignore[attr-defined]
        return round(float(x) / 1.45 * 2) / 2, round(float(z), 1)

    last = []
    for _, members in groupby(sorted(racked, key=lane), key=lane):
        y = sorted(float(item.T_world_object[1, 3]) for item in members)
        assert np.diff(y).max(initial=0.0) == pytest.approx(0.95, abs=0.16) or len(y) == 1
        last.append(y[-1])
    assert np.ptp(last) < 0.2
