import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.errors import ConfigError, PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.building.hall import HallConfig
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import Slot, build_site


def build(**settings: object) -> tuple[SceneDraft, list[Slot]]:
    draft, site = built(RackAisleConfig(**settings))  # type: ignore[arg-type]
    return draft, list(site.slots)


@pytest.mark.parametrize("sides", ["one", "both"])
def test_counts_of_frames_beams_and_slots(sides: str) -> None:
    draft, slots = build(bays=3, beam_levels=(1.4, 2.8, 4.2), sides=sides)
    racks = 1 if sides == "one" else 2
    names = [item.model for item in draft.instances]
    assert names.count("rack_frame_5500") == 4 * racks
    assert names.count("rack_beam_2700") == 3 * 3 * 2 * racks
    assert names.count("floor_slab") == 1
    assert len(slots) == 3 * 4 * 3 * racks
    assert len({slot.bay for slot in slots}) == 3 * 4 * racks
    assert [item.instance_id for item in draft.instances] == list(range(1, len(names) + 1))
    assert not any(item.dynamic for item in draft.instances)


@pytest.mark.parametrize("sides", ["one", "both"])
def test_beams_fill_the_bays_and_touch_the_uprights_without_overlap(sides: str) -> None:
    draft, _ = build(bays=2, sides=sides)
    rack = [item for item in draft.instances if item.model.startswith("rack")]
    owner = [item.instance_id for item in rack for _ in draft.models[item.model].collision]
    stack = BoxStack.of(
        [
            OrientedBox(item.T_world_object @ box.T_parent_box, box.size)
            for item in rack
            for box in draft.models[item.model].collision
        ]
    )
    pairs = stack.pairs(stack, 0.01)
    pairs = pairs[[owner[a] < owner[b] for a, b in pairs]]
    distance = stack.separation(stack, pairs).distance
    assert distance.min() > -1e-9
    beams = {item.instance_id for item in rack if "beam" in item.model}
    touching = [pair for pair, gap in zip(pairs, distance, strict=True) if gap < 1e-9]
    for beam in beams:
        assert (
            len({owner[a] if owner[b] == beam else owner[b] for a, b in touching if beam in (owner[a], owner[b])}) == 2
        )


def test_slots_leave_75_mm_between_pallets_and_uprights() -> None:
    _, slots = build(bays=1, beam_levels=())
    x = np.array([slot.T_world_slot[0, 3] for slot in slots])
    np.testing.assert_allclose(np.diff(x), 0.875)
    np.testing.assert_allclose(1.35 - 0.4 - x.max(), 0.075)
    for slot in slots:
        np.testing.assert_array_equal(slot.T_world_slot[:3, 0], [0, 1, 0])  # into the rack
        assert slot.T_world_slot[1, 3] == pytest.approx(0.55)


def test_slots_of_the_opposite_rack_face_the_aisle() -> None:
    _, slots = build(bays=1, beam_levels=(), sides="both", aisle_width=4.0)
    far = slots[3:]
    for slot in far:
        np.testing.assert_array_equal(slot.T_world_slot[:3, 0], [0, -1, 0])
        assert slot.T_world_slot[1, 3] == pytest.approx(-4.55)


def test_slots_lie_on_the_beams_and_end_under_the_next() -> None:
    _, slots = build(bays=1, beam_levels=(1.45, 2.9))
    headroom = {round(float(slot.T_world_slot[2, 3]), 6): slot.headroom for slot in slots}
    assert headroom == {0.0: pytest.approx(1.23), 1.45: pytest.approx(1.23), 2.9: pytest.approx(1.3)}


def test_the_hall_is_closed_on_four_sides() -> None:
    draft, _ = build()
    walls = [item for item in draft.instances if item.model == "wall"]
    corners = np.array([item.T_world_object[:2, 3] for item in walls])
    assert len(walls) == 4
    assert corners[:, 0].min() < -20 < 20 < corners[:, 0].max()
    assert corners[:, 1].min() < -20
    assert corners[:, 1].max() == pytest.approx(1.1 + 0.4 + 0.1)


def test_tolerances_move_frames_and_beams_within_en_15620_and_slots_follow_the_beams() -> None:
    exact, _ = build(bays=4, beams="step", mesh_decks=True)
    draft, slots = build(bays=4, beams="step", mesh_decks=True, tolerances=True)
    assert [item.model for item in draft.instances] == [item.model for item in exact.instances]
    moved = 0
    for sampled, made in zip(exact.instances, draft.instances, strict=True):
        way = np.abs(made.T_world_object - sampled.T_world_object)
        if sampled.model.startswith(("rack_frame", "step_beam")):
            moved += bool(way.max() > 1e-6)
            assert way[:3, 3].max() < 0.02
            assert way[:3, :3].max() < 0.05
        else:
            assert way.max() == 0.0
    assert moved == 5 + 2 * 2 * 4
    for slot in slots:
        z = float(slot.T_world_slot[2, 3])
        nominal = min((0.0, 1.45, 2.9), key=lambda level: abs(level - z))
        assert -1e-9 <= z - nominal < 0.008


def test_guards_stand_before_each_upright_and_at_both_ends() -> None:
    draft, _ = build(bays=3, guards=True, sides="both")
    names = [item.model for item in draft.instances]
    assert names.count("upright_guard") == 2 * 4
    assert names.count("rack_end_guard") == 2 * 2
    lowest = [i.T_world_object[2, 3] - draft.models[i.model].size[2] / 2 for i in draft.instances if "guard" in i.model]
    np.testing.assert_allclose(lowest, 0.0, atol=1e-9)


def test_equal_levels_hang_at_the_holes_and_end_under_the_trusses() -> None:
    layout = RackAisleConfig(levels=7, level_pitch=1.42)
    np.testing.assert_allclose(np.array(layout.tops[:3]), [1.4, 2.85, 4.25])
    for roof, clear in ((True, 7.2), (False, 9.0)):
        draft, site = built(layout, roof=roof)
        racks = [item for item in draft.instances if item.model.startswith("rack_")]
        tops = [item.T_world_object[2, 3] + draft.models[item.model].size[2] / 2 for item in racks]
        loads = [slot.T_world_slot[2, 3] + slot.headroom for slot in site.slots]
        assert clear - 1.6 < max(loads) <= clear
        assert max(tops) <= clear


@pytest.mark.parametrize(("rows", "depth"), [(0, 1.1), (1, 2.5), (2, 2.5 + 3.0 + 1.1), (3, 2 * 2.5 + 3.0)])
def test_racks_behind_stand_back_to_back_with_a_flue_and_aisles_between(rows: int, depth: float) -> None:
    layout = RackAisleConfig(bays=2, rows_behind=rows, aisle_width=3.0, sides="both", truck="reach")
    assert layout.depth == pytest.approx(depth)
    draft, site = built(layout)
    frames = [item for item in draft.instances if item.model.startswith("rack_frame")]
    y = sorted({round(float(item.T_world_object[1, 3]) - 0.55, 3) for item in frames if item.T_world_object[1, 3] > 0})
    np.testing.assert_allclose(y, [0.0, 1.4, 5.5, 6.9][: rows + 1])
    assert len(site.backdrop) == rows * len(site.slots)
    for slot in site.backdrop:
        # x of a slot points into its rack: odd rows face away from the aisle.
        assert abs(slot.T_world_slot[1, 0]) == pytest.approx(1.0)
    assert [item.model for item in draft.instances].count("row_spacer") == 2 * 3 * 2 * ((rows + 1) // 2)


def test_a_truck_wants_an_aisle_of_its_width() -> None:
    with pytest.raises(ConfigError, match=r"aisle_width must be 1.6-1.9 m for truck very_narrow, found 9.5"):
        RackAisleConfig(truck="very_narrow")


def test_more_racks_than_the_hall_holds_are_rejected() -> None:
    layout = RackAisleConfig(rows_behind=8, aisle_width=6.0)
    with pytest.raises(PlacementError, match=r"lower layout\.rows_behind"):
        build_site(SceneDraft(), layout, HallConfig(), np.random.default_rng(0))


def test_a_level_carries_what_the_load_notice_says_and_the_floor_more() -> None:
    _, slots = build(bays=1, bay_load=2400.0)
    assert [slot.most_mass for slot in slots] == 3 * [np.inf] + 6 * [pytest.approx(800.0)]


def test_signs_hang_free_of_each_other_on_what_carries_them() -> None:
    draft, slots = build(bays=2, beams="step", signs=True, guards=True, beam_levels=(1.5, 3.0), support_bars=True)
    names = [item.model for item in draft.instances]
    assert (names.count("load_notice"), names.count("frame_label")) == (2, 3)
    assert names.count("beam_label") == len([slot for slot in slots if slot.T_world_slot[2, 3] > 0])
    assert names.count("pallet_support_bar") == 2 * names.count("beam_label")
    solids = draft.solids()
    kind = {item.instance_id: item.model for item in draft.instances}
    pairs = solids.boxes.pairs(solids.boxes, 0.0)
    pairs = pairs[solids.owner[pairs[:, 0]] < solids.owner[pairs[:, 1]]]
    deep = solids.boxes.separation(solids.boxes, pairs).distance < -1e-6
    touched = {frozenset((kind[solids.owner[a]], kind[solids.owner[b]])) for a, b in pairs[deep]}
    assert not {name for pair in touched for name in pair} & {"load_notice", "frame_label", "beam_label"}
