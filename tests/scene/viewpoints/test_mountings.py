import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.viewpoints.mountings import AMR, FORKLIFT, MOUNTINGS, pose_on_floor

PRIORS = {
    "forklift_mast": (1.8, 2.2, -25.0, -10.0),
    "forklift_forks": (0.25, 0.55, -5.0, 5.0),
    "forklift_guard": (2.1, 2.4, -20.0, -5.0),
    "amr": (0.3, 1.0, -5.0, 5.0),
    "level": (0.4, 3.5, 0.0, 0.0),
    "post": (0.3, 3.5, -30.0, 5.0),
    "ceiling": (4.0, 8.0, -90.0, -40.0),
}


@pytest.mark.parametrize("kind", MOUNTINGS)
def test_heights_and_pitches_are_the_documented_ones(kind: str) -> None:
    mounting = MOUNTINGS[kind]
    found = (mounting.height.low, mounting.height.high, mounting.pitch_deg.low, mounting.pitch_deg.high)
    assert found == pytest.approx(PRIORS[kind])
    assert mounting.vehicle is None or mounting.vehicle.rear < mounting.forward <= mounting.tip


def test_a_camera_sits_ahead_of_the_vehicles_origin_and_looks_down_by_its_pitch() -> None:
    mounting = MOUNTINGS["forklift_forks"]
    T = mounting.camera(pose_on_floor(1.0, 2.0, 0.5), 0.4, np.deg2rad(-10.0))
    np.testing.assert_allclose(T[:3, 3], [1 + mounting.forward * np.cos(0.5), 2 + mounting.forward * np.sin(0.5), 0.4])
    flat = np.cos(np.deg2rad(10.0))
    np.testing.assert_allclose(T[:3, 2], [flat * np.cos(0.5), flat * np.sin(0.5), -np.sin(np.deg2rad(10.0))])
    assert T[2, 0] == pytest.approx(0.0, abs=1e-12)  # no roll


def test_the_fork_camera_is_just_behind_the_tips_and_only_mast_and_forks_go_up() -> None:
    assert 0.1 < FORKLIFT.tip - MOUNTINGS["forklift_forks"].forward < 0.3
    assert [kind for kind, mounting in MOUNTINGS.items() if mounting.lifts] == ["forklift_mast", "forklift_forks"]


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
