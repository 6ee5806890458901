import numpy as np
import pytest

from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS
from warehouse_sim.scene.viewpoints.vehicles import FORKLIFT, pose_on_floor

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
