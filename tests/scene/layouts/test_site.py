from typing import Any

import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.errors import ConfigError
from warehouse_sim.scene.building.floor import add_tyre_marks
from warehouse_sim.scene.building.hall import HallConfig
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.mixed import MixedConfig
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import Layout, aisle_area, build_site


@pytest.mark.parametrize("kind", Layout.kinds)
def test_every_kind_reads_back_and_builds_places_outside_the_aisle(kind: str) -> None:
    layout = Layout.from_plain({"kind": kind}, "here")
    assert type(layout) is Layout.kinds[kind]
    assert Layout.from_plain(layout.to_plain(), "here") == layout
    draft, site = built(layout)
    places = [slot.T_world_slot for slot in site.slots] + [T for lane in site.lanes for T in lane.T_world_places]
    assert bool(places) == (kind not in ("cantilever", "small_parts", "mezzanine"))
    assert site.aisle == aisle_area(layout)
    for T in places:
        assert not site.aisle.contains(T[:3, 3])
        assert site.aisle.x_min <= T[0, 3] <= site.aisle.x_max
    assert not any(item.dynamic for item in draft.instances)


def test_without_a_kind_it_is_a_rack_aisle() -> None:
    assert Layout.from_plain({"bays": 2}, "here") == RackAisleConfig(bays=2)


@pytest.mark.parametrize(
    ("plain", "message"),
    [
        ({"kind": "attic"}, "here: kind must be one of 'block_storage', .*found 'attic'"),
        ({"kind": "block_storage", "bays": 2}, "bays is not a setting"),
        ({"kind": "mixed", "front": {"kind": "mixed"}}, "must be single layouts"),
        ({"kind": "mixed", "back": {"kind": "dock_staging"}}, "make dock_staging the front"),
        ({"kind": "rack_aisle", "mesh_decks": True}, "mesh_decks need step beams"),
        ({"kind": "rack_aisle", "pallets_per_bay": 4}, "take fewer pallets_per_bay"),
        ({"kind": "conveyor_pickup", "segments": 0}, "segments must be 1-12, found 0"),
    ],
)
def test_bad_layouts_name_the_place(plain: Any, message: str) -> None:
    with pytest.raises(ConfigError, match=message) as caught:
        Layout.from_plain(plain, "here")
    assert str(caught.value).startswith("here")


def test_a_mixed_aisle_has_the_front_before_it_and_the_back_behind() -> None:
    _, site = built(MixedConfig(aisle_width=6.0))
    assert min(slot.T_world_slot[1, 3] for slot in site.slots) > 0.0
    assert max(T[1, 3] for lane in site.lanes for T in lane.T_world_places) < -6.0


@pytest.mark.parametrize("columns", ["steel", "concrete"])
def test_a_whole_hall_leaves_the_racks_and_the_aisle_free(columns: Any) -> None:
    draft, layout = SceneDraft(), RackAisleConfig(sides="both")
    hall = HallConfig(floor="epoxy", walls="cladding", roof=True, columns=columns, tyre_marks=3)
    build_site(draft, layout, hall, np.random.default_rng(0))
    names = [item.model for item in draft.instances]
    assert names.count("floor_slab_epoxy") == 1
    assert names.count("wall_clad") == 4
    assert names.count("ceiling") == 1
    assert names.count(f"column_{columns}") == 8
    assert sum(name.startswith("tyre_mark") for name in names) == 3
    for item in draft.instances:
        if item.model.startswith("column"):
            reach = draft.models[item.model].size[1] / 2
            y = item.T_world_object[1, 3]
            assert y - reach > layout.depth or y + reach < -layout.aisle_width - layout.depth


def test_tyre_marks_lie_on_the_floor_of_their_area() -> None:
    draft, area = SceneDraft(), aisle_area(RackAisleConfig())
    add_tyre_marks(draft, 10, area, np.random.default_rng(0))
    z = [item.T_world_object[2, 3] - draft.models[item.model].size[2] / 2 for item in draft.instances]
    assert len(z) == 10
    assert all(0.0 < height < 0.0003 for height in z)
    assert all(area.contains(item.T_world_object[:3, 3]) for item in draft.instances)
