"""Trucks in the aisles between the racks behind stand there, clear of everything, and move nothing else."""

import numpy as np

from tests.scene.sites import built
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.hall import HallConfig
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import build_site
from warehouse_sim.scene.traffic import TrafficConfig, add_side_trucks
from warehouse_sim.scene.unit_load import UnitLoadConfig


def test_side_aisles_lie_between_the_rows_behind() -> None:
    layout = RackAisleConfig(bays=4, rows_behind=2, aisle_width=2.9, sides="both", truck="reach")
    site = build_site(SceneDraft(), layout, HallConfig(), np.random.default_rng(0))
    found = sorted((round(area.y_min, 3), round(area.y_max, 3)) for area in site.side_aisles)
    assert found == [(-2.9 - 5.4, -2.9 - 2.5), (2.5, 5.4)]
    assert not build_site(
        SceneDraft(), RackAisleConfig(rows_behind=1), HallConfig(), np.random.default_rng(0)
    ).side_aisles


def test_trucks_stand_in_side_aisles_and_touch_no_rack() -> None:
    layout = RackAisleConfig(bays=5, rows_behind=2, aisle_width=3.0, truck="reach")
    config = TrafficConfig(side_trucks=Distribution.constant(3), truck_kinds=("reach", "stacker"))
    draft, site = built(layout)
    before, racks = len(draft.instances), draft.solids().boxes
    add_side_trucks(draft, config, UnitLoadConfig(), site.side_aisles, np.random.default_rng(1))
    added = draft.instances[before:]
    assert any(draft.models[item.model].class_name == "forklift" for item in added)
    for item in added:
        assert not item.dynamic
        box = OrientedBox(item.T_world_object, draft.models[item.model].size)
        assert all(site.side_aisles[0].contains(corner) for corner in box.corners())
        for solid in draft.models[item.model].collision:
            assert racks.subset(racks.centre[:, 2] > 0.0).clear_of(solid.placed(item.T_world_object), 0.05)
