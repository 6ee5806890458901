import numpy as np
import pytest

from warehouse_sim.generation.light.dimming import FLUX, HEIGHT, work_lights
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z
from warehouse_sim.scene.lighting.photometry import luminous_flux
from warehouse_sim.schema import Viewpoint


def test_two_lights_on_the_guard_of_the_vehicle_shine_ahead_and_down() -> None:
    T_world_vehicle = make_transform(rotation_z(0.5), np.array([1.0, 2.0, 0.0]))
    camera = level_camera(np.array([1.5, 2.3, 0.4]), 0.5, 0.0)
    lights = work_lights(Viewpoint(camera, T_world_vehicle=T_world_vehicle), 5000.0)
    middle = np.mean([light.position for light in lights], axis=0)
    np.testing.assert_allclose(middle, [1.0, 2.0, HEIGHT])
    assert np.linalg.norm(lights[0].position - lights[1].position) == pytest.approx(0.9)
    for light in lights:
        assert light.direction[:2] @ [np.cos(0.5), np.sin(0.5)] > 0.9
        assert -0.3 < light.direction[2] < 0.0
        assert np.linalg.norm(light.direction) == pytest.approx(1.0)
        assert luminous_flux(light) == pytest.approx(FLUX)
        assert light.casts_shadow


def test_a_camera_that_nothing_carries_is_lit_from_above_itself() -> None:
    pitched = level_camera(np.array([3.0, -1.0, 0.6]), 2.0, -0.4)
    lights = work_lights(Viewpoint(pitched), 5000.0)
    np.testing.assert_allclose(np.mean([light.position for light in lights], axis=0), [3.0, -1.0, HEIGHT])
    assert all(light.direction[:2] @ [np.cos(2.0), np.sin(2.0)] > 0.9 for light in lights)
