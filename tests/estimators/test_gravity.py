"""Gravity in closed form: a camera that is turned by known angles, a floor that is drawn by hand."""

import numpy as np
import pytest

from warehouse_sim.estimators.gravity import down_from_floor, down_of_camera, upright_frame
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera


@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (-0.3, 0.0), (0.2, 0.1)])
def test_down_is_what_a_plumb_line_shows_and_the_upright_frame_is_a_turn_to_it(pitch: float, roll: float) -> None:
    T_world_camera = level_camera(np.array([1.0, 2.0, 1.5]), 0.7, pitch, roll)
    down = down_of_camera(T_world_camera)
    np.testing.assert_allclose(T_world_camera[:3, :3] @ down, [0.0, 0.0, -1.0], atol=1e-12)
    R = upright_frame(down)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) > 0.99
    np.testing.assert_allclose(R.T @ -down, [0.0, 0.0, 1.0], atol=1e-12)
    assert (R.T @ [0.0, 0.0, 1.0])[1] == pytest.approx(0.0, abs=1e-12)  # the camera looks along x, up or down


@pytest.mark.parametrize("pitch", [-0.5, -0.2, 0.0])
def test_a_floor_in_sight_tells_gravity_and_a_wall_does_not(pitch: float) -> None:
    camera = PinholeCamera(160, 120, 120.0, 120.0, 79.5, 59.5)
    T_world_camera = level_camera(np.array([0.0, 0.0, 1.2]), 0.0, pitch, 0.05)
    v, u = np.mgrid[:120, :160].reshape(2, -1)
    rays = camera.rays_at(u, v)
    world = rays @ T_world_camera[:3, :3].T
    rng = np.random.default_rng(3)
    floor = np.where(world[:, 2] < -1e-3, -1.2 / np.minimum(world[:, 2], -1e-3), 100.0)
    wall = 4.0 / np.maximum(world[:, 0], 0.1)
    depth = np.minimum(floor, wall) + rng.normal(0.0, 0.003, len(u))
    found = down_from_floor(camera, depth.reshape(120, 160).astype(np.float32), rng)
    assert found is not None
    assert np.degrees(np.arccos(found @ down_of_camera(T_world_camera))) < 0.3
    assert down_from_floor(camera, wall.reshape(120, 160).astype(np.float32), rng) is None
