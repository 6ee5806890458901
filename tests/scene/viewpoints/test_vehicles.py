import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.viewpoints.vehicles import AMR, FORKLIFT, pose_on_floor


def test_the_trucks_outline_is_the_catalogs() -> None:
    length, width, height = catalog_object("forklift").size
    assert FORKLIFT.tip - FORKLIFT.rear == pytest.approx(length, abs=1e-3)
    assert pytest.approx(width, abs=1e-3) == FORKLIFT.width
    assert pytest.approx(height, abs=1e-3) == FORKLIFT.height


@pytest.mark.parametrize("yaw", [0.0, 0.8])
def test_boxes_reach_from_rear_to_fork_tips_in_the_vehicles_frame(yaw: float) -> None:
    boxes = FORKLIFT.boxes(pose_on_floor(2.0, 1.0, yaw), lift=1.0)
    ahead = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    along = np.array([(box.corners() - [2.0, 1.0, 0.0]) @ ahead for box in boxes])
    assert along.min() == pytest.approx(FORKLIFT.rear)
    assert along.max() == pytest.approx(FORKLIFT.tip)
    assert boxes[1].corners()[:, 2].max() == pytest.approx(1.15)  # the blades go up, the body stays
    assert boxes[0].corners()[:, 2].max() == pytest.approx(FORKLIFT.height)


def test_a_robot_without_forks_is_one_box_above_what_lies_flat() -> None:
    (low,), (high,) = BoxStack.of(AMR.boxes(pose_on_floor(0.0, 0.0, 0.0))).extents()
    np.testing.assert_allclose(high[:2] - low[:2], [0.96, 0.65])
    assert 0.05 < low[2] < 0.1
    assert AMR.tip == AMR.front
