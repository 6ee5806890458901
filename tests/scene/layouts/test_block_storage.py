import numpy as np
import pytest

from tests.scene.sites import built
from warehouse_sim.scene.layouts.block_storage import BlockStorageConfig


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
