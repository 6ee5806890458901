from collections import Counter

import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.traffic import TrafficConfig, add_traffic
from warehouse_sim.scene.trucks_at_work import CLEARANCE

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
