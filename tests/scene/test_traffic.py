from collections import Counter

import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.catalog.traffic.working import WORKING
from warehouse_sim.errors import ConfigError, PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene import Distribution, trucks_at_work
from warehouse_sim.scene.building.hall import HallConfig
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import build_site
from warehouse_sim.scene.loads.unit_load import UnitLoadConfig
from warehouse_sim.scene.traffic import TrafficConfig, add_side_trucks, add_traffic
from warehouse_sim.scene.trucks_at_work import CLEARANCE, KINDS, Crew, add_trucks_at_work, sample_crew

BUSY = TrafficConfig(
    forklifts=Distribution.constant(2),
    pallet_jacks=Distribution.constant(2),
    people=Distribution.constant(3),
    cones=Distribution.constant(3),
    cartons=Distribution.constant(3),
)


@pytest.mark.parametrize("seed", range(3))
def test_everything_requested_for_stands_on_the_floor_clear_of_all_else(seed: int) -> None:
    draft, site = built(RackAisleConfig())
    before = len(draft.instances)
    add_traffic(draft, BUSY, ["carton_400x300x200"], site.aisle, np.random.default_rng(seed))
    added = draft.instances[before:]
    assert Counter(draft.models[item.model].class_name for item in added) == {
        "forklift": 2,
        "pallet_jack": 2,
        "person": 3,
        "cone": 3,
        "carton": 3,
    }
    outer = BoxStack.of([OrientedBox(item.T_world_object, draft.models[item.model].size) for item in added])
    pairs = np.array([(a, b) for a in range(len(added)) for b in range(a)])
    assert outer.separation(outer, pairs).distance.min() >= CLEARANCE - 1e-9
    low, _ = outer.extents()
    for item, bottom in zip(added, low[:, 2], strict=True):
        loose = draft.models[item.model].class_name == "carton"
        assert item.dynamic == loose
        assert bottom == pytest.approx(0.0005 if loose else 0.0, abs=1e-6)
        assert site.aisle.contains(item.T_world_object[:3, 3])
    assert len({item.group for item in added if item.dynamic}) == 3


def test_a_full_floor_is_an_error_that_names_the_setting() -> None:
    crowd = TrafficConfig(forklifts=Distribution.constant(20))
    with pytest.raises(PlacementError, match=r"no room for forklift \d+ of 20 .*lower traffic.forklifts"):
        add_traffic(SceneDraft(), crowd, [], Area(-3, 3, -4, 0), np.random.default_rng(0))


def test_no_traffic_uses_up_nothing_of_the_stream() -> None:
    rng, draft = np.random.default_rng(0), SceneDraft()
    add_traffic(draft, TrafficConfig(), [], Area(-3, 3, -4, 0), rng)
    assert draft.instances == []
    assert rng.random() == np.random.default_rng(0).random()


# Trucks at work: loads lie on the blades, drivers sit in their seats, and all is clear of the rest.


def _stack(pieces: list) -> BoxStack:
    return BoxStack.of([box.placed(T) for model, T in pieces for box in model.collision])


def _drops(crew: Crew) -> list[float]:
    """Return of each load the gap (m) between its pallet and what is under it; negative where it sinks in."""
    carrier = _stack([piece for piece in crew.single if piece[0].class_name != "person"])
    gaps = []
    for load in crew.loads:
        pallet = _stack(load[:1])
        pairs = np.array([(a, b) for a in range(len(pallet.centre)) for b in range(len(carrier.centre))])
        result = pallet.separation(carrier, pairs)
        gaps.append(float(result.distance.min()))
    return gaps


@pytest.fixture
def all_laden(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trucks_at_work, "_LADEN_FRACTION", 1.0)


@pytest.mark.usefixtures("all_laden")
@pytest.mark.parametrize("kind", KINDS)
def test_a_load_touches_its_truck_and_does_not_go_through_it(kind: str) -> None:
    laden = 0
    for seed in range(6):
        crew = sample_crew(kind, UnitLoadConfig(), np.random.default_rng(seed))
        laden += len(crew.loads)
        for gap in _drops(crew):
            assert -0.0005 < gap < 0.0005
    assert laden >= 6


@pytest.mark.usefixtures("all_laden")
@pytest.mark.parametrize("kind", KINDS)
def test_loads_are_clear_of_drivers_and_of_each_other(kind: str) -> None:
    for seed in range(4):
        crew = sample_crew(kind, UnitLoadConfig(), np.random.default_rng(seed))
        people = [piece for piece in crew.single if piece[0].class_name == "person"]
        groups = [_stack(load) for load in crew.loads] + ([_stack(people)] if people else [])
        for n, one in enumerate(groups):
            for other in groups[:n]:
                pairs = np.array([(a, b) for a in range(len(one.centre)) for b in range(len(other.centre))])
                assert one.separation(other, pairs).distance.min() > 0.0


@pytest.mark.parametrize("kind", [kind for kind in KINDS if WORKING[KINDS[kind]].driver is not None])
def test_drivers_are_within_reach_of_the_truck(kind: str) -> None:
    for seed in range(3):
        crew = sample_crew(kind, UnitLoadConfig(), np.random.default_rng(seed))
        truck, person = crew.single[0], next(piece for piece in crew.single if piece[0].class_name == "person")
        shape, hull = _stack([person]), _stack([truck])
        pairs = np.array([(a, b) for a in range(len(shape.centre)) for b in range(len(hull.centre))])
        assert shape.separation(hull, pairs).distance.min() < 0.12
        assert person[1][2, 3] - person[0].size[2] / 2 > -0.001


def test_all_stand_clear_on_the_floor_of_the_aisle_and_fixed() -> None:
    draft, site = built(RackAisleConfig())
    before = len(draft.instances)
    rng = np.random.default_rng(3)
    add_trucks_at_work(draft, 4, tuple(KINDS), UnitLoadConfig(), site.aisle, rng)
    added = draft.instances[before:]
    assert not any(item.dynamic for item in added)
    trucks = [item for item in added if item.model in WORKING and item.model != "work_cart"]
    assert len(trucks) >= 3
    for item in trucks:
        box = OrientedBox(item.T_world_object, draft.models[item.model].size)
        assert box.corners()[:, 2].min() == pytest.approx(0.0, abs=1e-6)
        assert all(site.aisle.contains(corner) for corner in box.corners())
        heading = np.degrees(np.arctan2(item.T_world_object[1, 0], item.T_world_object[0, 0]))
        assert abs((heading + 45.0) % 90.0 - 45.0) < 15.0
    others = BoxStack.of([OrientedBox(item.T_world_object, draft.models[item.model].size) for item in trucks])
    pairs = np.array([(a, b) for a in range(len(trucks)) for b in range(a)])
    assert others.separation(others, pairs).distance.min() >= 0.3 - 1e-9


def test_none_use_up_nothing_of_the_stream() -> None:
    rng, draft = np.random.default_rng(0), SceneDraft()
    add_trucks_at_work(draft, 0, tuple(KINDS), UnitLoadConfig(), Area(-3, 3, -4, 0), rng)
    assert draft.instances == []
    assert rng.random() == np.random.default_rng(0).random()


def test_unknown_kinds_of_trucks_are_rejected_with_those_there_are() -> None:
    with pytest.raises(ConfigError, match=r"truck_kinds must list some of counterbalance, .*found .*tank"):
        TrafficConfig(truck_kinds=("tank",))


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
