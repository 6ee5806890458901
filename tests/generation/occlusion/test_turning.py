from dataclasses import replace

import numpy as np
import pytest

from tests.generation.occlusion.scenes import CAMERA, EYE, VIEW, hall, occluded_scene_of
from warehouse_sim.generation.occlusion.standing import turn_to_truncate
from warehouse_sim.geometry.pose import make_transform


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("wanted", [0.2, 0.5, 0.8])
def test_the_border_cuts_as_much_as_requested(side: float, wanted: float) -> None:
    occluded = occluded_scene_of(hall())
    turned = turn_to_truncate(occluded, VIEW, 2, wanted, 0.02, 600, side)
    assert turned is not None
    sight = occluded.look(2, turned.T_world_camera, 4000)
    assert sight is not None
    assert sight.fraction == pytest.approx(wanted, abs=0.03)
    assert occluded.main_kind(sight) == "border"
    np.testing.assert_allclose(turned.T_world_camera[:3, 3], EYE)
    # The axis keeps its pitch; turned to the left, the target is at the image's right border.
    assert turned.T_world_camera[2, 2] == pytest.approx(VIEW.T_world_camera[2, 2])
    u = CAMERA.project((np.linalg.inv(turned.T_world_camera) @ [0.0, 0.0, 0.07, 1.0])[:3])[0]
    assert (u > 500) if side > 0 else (u < 140)


def test_a_vehicle_turns_with_its_camera() -> None:
    vehicle = make_transform(translation=np.array([0.0, -5.0, 0.0]))
    riding = replace(VIEW, T_world_vehicle=vehicle, velocity=(0.0, 1.0, 0.0))
    turned = turn_to_truncate(occluded_scene_of(hall()), riding, 2, 0.5, 0.05, 600, 1.0)
    assert turned is not None
    assert turned.T_world_vehicle is not None
    before = np.linalg.inv(vehicle) @ VIEW.T_world_camera
    np.testing.assert_allclose(np.linalg.inv(turned.T_world_vehicle) @ turned.T_world_camera, before, atol=1e-12)
    assert np.linalg.norm(turned.velocity) == pytest.approx(1.0)
    assert turned.velocity[0] < -0.3


def test_a_target_that_is_hidden_more_than_requested_cannot_be_cut() -> None:
    occluded = occluded_scene_of(hall(("forklift", 0.0, -2.2)))
    assert turn_to_truncate(occluded, VIEW, 2, 0.9, 0.02, 600, 1.0) is None
