from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.catalog.building.conveyor import CONVEYORS
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.physics import settle_scene
from warehouse_sim.scene.building.floor import add_tyre_marks
from warehouse_sim.scene.building.hall import HallConfig
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.block_storage import BlockStorageConfig
from warehouse_sim.scene.layouts.cantilever import CantileverConfig
from warehouse_sim.scene.layouts.conveyor_pickup import ConveyorPickupConfig
from warehouse_sim.scene.layouts.dock_staging import DockStagingConfig
from warehouse_sim.scene.layouts.drive_in import DriveInConfig
from warehouse_sim.scene.layouts.mezzanine import MezzanineConfig
from warehouse_sim.scene.layouts.mixed import MixedConfig
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import Layout, aisle_area, build_site
from warehouse_sim.scene.layouts.small_parts import SmallPartsConfig
from warehouse_sim.scene.loads.resting import drop_to_rest
from warehouse_sim.scene.sampling import sample_scene
from warehouse_sim.schema import ObjectInstance


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


@pytest.mark.parametrize(("sides", "blocks"), [("one", 1), ("both", 2)])
def test_lanes_lead_away_from_the_aisle_and_do_not_overlap(sides: str, blocks: int) -> None:
    _, site = built(
        BlockStorageConfig(lanes=5, lane_depth=3, lane_width=1.1, stack_pitch=1.3, sides=sides, aisle_width=7.0)
    )
    assert len(site.lanes) == 5 * blocks
    assert site.slots == ()
    places = np.array([[T[:2, 3] for T in lane.T_world_places] for lane in site.lanes])
    front = places[places[:, 0, 1] > 0]
    np.testing.assert_allclose(front[:, :, 1], np.broadcast_to([0.65, 1.95, 3.25], (5, 3)))
    np.testing.assert_allclose(np.diff(np.sort(front[:, 0, 0])), 1.1)
    for lane in site.lanes:
        into = lane.T_world_places[0][:2, 0]
        assert into @ (lane.T_world_places[1][:2, 3] - lane.T_world_places[0][:2, 3]) == pytest.approx(1.3)
        assert lane.footprint == pytest.approx((1.24, 1.04))
    if blocks == 2:
        np.testing.assert_allclose(places[places[:, 0, 1] < 0][:, 0, 1], -7.65)


def test_lane_lines_are_painted_on_the_floor_beside_the_lanes() -> None:
    draft, _ = built(BlockStorageConfig(lanes=4, lane_depth=3, stack_pitch=1.4))
    lines = [item for item in draft.instances if draft.models[item.model].class_name == "marking"]
    assert {round(float(item.T_world_object[0, 3]), 3) for item in lines} == {-2.2, -1.1, 0.0, 1.1, 2.2}
    for item in lines:
        size = draft.models[item.model].size
        assert item.T_world_object[2, 3] == pytest.approx(size[2] / 2)
        assert item.T_world_object[1, 3] - size[0] / 2 + 1e-6 > 0.0
        assert item.T_world_object[1, 3] + size[0] / 2 <= 4.2 + 1e-6


def test_loads_lie_lengthwise_on_the_rollers_and_keep_their_distance() -> None:
    config = ConveyorPickupConfig(segments=4, pitch=1.7)
    _, site = built(config)
    x = np.array([slot.T_world_slot[0, 3] for slot in site.slots])
    np.testing.assert_allclose(np.diff(x), 1.7)
    assert np.abs(x).max() + 0.61 <= config.length / 2
    assert len(x) == int((9.6 - 1.3) / 1.7) + 1
    kind = CONVEYORS["pallet_conveyor"]
    for slot in site.slots:
        np.testing.assert_array_equal(slot.T_world_slot[:3, :3], np.eye(3))
        np.testing.assert_allclose(slot.T_world_slot[1:3, 3], [kind.width / 2, kind.height])


def test_segments_join_and_stand_on_the_floor() -> None:
    draft, _ = built(ConveyorPickupConfig(segments=5))
    for name, count in (("pallet_conveyor", 5), ("roller_conveyor", 6)):
        items = [item for item in draft.instances if item.model == name]
        x = np.sort([item.T_world_object[0, 3] for item in items])
        assert len(x) == count
        np.testing.assert_allclose(np.diff(x), CONVEYORS[name].length)
        np.testing.assert_allclose([item.T_world_object[2, 3] for item in items], CONVEYORS[name].height / 2)


def build(**settings: object) -> tuple[SceneDraft, DockStagingConfig, int]:
    config = DockStagingConfig(**settings)  # type: ignore[arg-type]
    draft, site = built(config)
    return draft, config, len(site.lanes)


def named(draft: SceneDraft, name: str) -> list[ObjectInstance]:
    return [item for item in draft.instances if item.model == name]


@pytest.mark.parametrize(("doors", "fraction", "opened"), [(1, 0.0, 0), (3, 1.0, 3), (4, 0.5, 2), (6, 0.5, 3)])
def test_each_opening_of_the_wall_has_a_door_and_open_ones_a_trailer(doors: int, fraction: float, opened: int) -> None:
    draft, _, lanes = build(doors=doors, open_fraction=fraction, lanes_per_door=2)
    assert lanes == 2 * doors
    leaves = named(draft, "dock_door_open") + named(draft, "dock_door_closed")
    openings = named(draft, "wall_module_dock")
    x = sorted(float(item.T_world_object[0, 3]) for item in openings)
    assert x == sorted(float(item.T_world_object[0, 3]) for item in leaves)
    assert len(x) == len(named(draft, "dock_leveller")) == doors
    for name in ("dock_door_open", "trailer", "dock_seal"):
        assert len(named(draft, name)) == opened
    assert len(openings) + len(named(draft, "wall_module")) == 8


def test_doors_end_at_the_wall_trailers_begin_behind_it_and_the_apron_is_free() -> None:
    draft, config, _ = build(open_fraction=0.5)
    wall = named(draft, "wall_module_dock")[0]
    inner = wall.T_world_object[1, 3] - draft.models["wall_module_dock"].size[1] / 2
    assert inner == pytest.approx(config.depth)
    for name in ("dock_door_open", "dock_door_closed"):
        for item in named(draft, name):
            size = draft.models[name].size
            assert item.T_world_object[1, 3] + size[1] / 2 == pytest.approx(inner)
            assert item.T_world_object[2, 3] == pytest.approx(size[2] / 2)
    for name, start in (("dock_seal", 0.2), ("trailer", 0.4)):  # the wall is 0.2 m thick, and so is the seal
        for item in named(draft, name):
            size = draft.models[name].size
            assert item.T_world_object[1, 3] - size[1] / 2 == pytest.approx(inner + start)
            assert item.T_world_object[1, 3] + size[1] / 2 < 24.0
    # At rest a leveller ends at the wall; at an open door its lip lies on the trailer's floor.
    open_x = {float(item.T_world_object[0, 3]) for item in named(draft, "trailer")}
    for item in named(draft, "dock_leveller"):
        end = item.T_world_object[1, 3] + draft.models["dock_leveller"].size[1] / 2 - inner
        assert end == pytest.approx(0.55 if float(item.T_world_object[0, 3]) in open_x else 0.0)
    assert config.apron > draft.models["dock_leveller"].size[1]


def test_too_many_lanes_for_a_door_are_rejected() -> None:
    with pytest.raises(ConfigError, match=r"4 lanes of 1.6 m do not fit the 6.0 m"):
        DockStagingConfig(lanes_per_door=4, lane_width=1.6)


# Drive-in racks: pallets span the lane and lie on both rails; lanes are filled from their far end.


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


# Layouts that bring their own goods: all of them lie on something, none in anything.


GOODS = ("long_goods", "bin", "tote", "carton")
LAYOUTS: tuple[Layout, ...] = (
    CantileverConfig(fields=8, levels=5, sides="both"),
    SmallPartsConfig(bays=3, rows=3, sides="both"),
    MezzanineConfig(panels=2, panel_rows=2),
)


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.kind)
@pytest.mark.parametrize("seed", [0, 1])
def test_goods_rest_on_what_is_under_them(layout: Layout, seed: int) -> None:
    draft, _ = built(layout, seed)
    solids = draft.solids()
    goods = [item for item in draft.instances if draft.models[item.model].class_name in GOODS]
    assert len(goods) > 20
    for item in goods:
        mine = solids.of_objects([item.instance_id])
        near = solids.near(*solids.extent_of([item.instance_id]), 0.05) & ~mine
        drop = drop_to_rest(solids.boxes.subset(mine), solids.boxes.subset(near))
        assert drop == pytest.approx(0.0, abs=1e-9), item.model


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.kind)
def test_nothing_is_inside_something_else(layout: Layout) -> None:
    draft, _ = built(layout)
    solids = draft.solids()
    kind = {item.instance_id: draft.models[item.model].class_name for item in draft.instances}
    pairs = solids.boxes.pairs(solids.boxes)
    pairs = pairs[solids.owner[pairs[:, 0]] < solids.owner[pairs[:, 1]]]
    deep = solids.boxes.separation(solids.boxes, pairs).distance < -1e-6
    found = {frozenset((kind[solids.owner[a]], kind[solids.owner[b]])) for a, b in pairs[deep]}
    building = {"wall", "floor", "column"}
    assert not {pair for pair in found if not pair <= building}


def test_long_goods_lie_on_two_arms_or_more() -> None:
    draft, _ = built(LAYOUTS[0], 2)
    arms = [item.T_world_object[0, 3] for item in draft.instances if item.model.startswith("cantilever_column")]
    for item in draft.instances:
        model = draft.models[item.model]
        if model.class_name == "long_goods":
            away = np.abs(np.unique(np.round(arms, 6)) - item.T_world_object[0, 3])
            assert np.count_nonzero(away < model.size[0] / 2 - 0.05) >= 2, item.model
