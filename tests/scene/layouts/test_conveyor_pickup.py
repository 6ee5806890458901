import numpy as np

from tests.scene.sites import built
from warehouse_sim.catalog.building.conveyor import CONVEYORS
from warehouse_sim.scene.layouts.conveyor_pickup import ConveyorPickupConfig


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
