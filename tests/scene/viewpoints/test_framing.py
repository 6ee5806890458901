from dataclasses import replace

import numpy as np
import pytest

from tests.scene.viewpoints.spaces import bare_space
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import (
    angles_to,
    is_framed,
    is_off_axis,
    shows,
    target_in_view,
    targets_in_frame,
)
from warehouse_sim.schema import Viewpoint

CONFIG = ViewpointsConfig()
NEAR, FAR = ("epal1", (3.0, -4.0, 0.072), 0.0), ("epal1", (6.0, -3.0, 0.072), 0.0)
VIEW = Viewpoint(level_camera(np.array([0.0, -4.0, 0.5]), 0.0))


def test_angles_are_those_beside_and_above_the_axis() -> None:
    bearing, elevation = angles_to(
        level_camera(np.array([0.0, 0.0, 1.0]), 0.0, np.deg2rad(-20.0)), np.array([[2.0, 2.0, 1.0], [2.0, 0.0, 1.0]])
    )
    assert elevation[1] == pytest.approx(np.deg2rad(20.0))
    assert bearing[1] == pytest.approx(0.0)
    # Tilting the camera by 20 degrees shortens the depth of a point at 45 degrees.
    assert bearing[0] == pytest.approx(np.arctan2(1.0, np.cos(np.deg2rad(20.0))))


def test_a_quick_look_rejects_what_the_exact_one_rejects() -> None:
    rng, framed = np.random.default_rng(0), []
    for _ in range(500):
        place, point = rng.uniform(-3.0, 3.0, (2, 3))
        yaw, pitch, roll = rng.uniform([-np.pi, -1.5, -0.2], [np.pi, 1.0, 0.2])
        config = replace(CONFIG, max_elevation_deg=float(rng.uniform(1, 45)), max_bearing_deg=float(rng.uniform(1, 80)))
        framed.append(is_framed(level_camera(place, yaw, pitch, roll), point, config))
        assert is_off_axis(point.tolist(), place.tolist(), (yaw, pitch, roll), config) != framed[-1]
    assert 20 < sum(framed) < 480


def test_targets_in_frame_come_by_distance_and_the_edge_counts() -> None:
    space = bare_space(FAR, NEAR, ("epal1", (-3.0, -4.0, 0.072), 0.0), ("epal1", (2.0, -7.0, 0.072), 0.0))
    assert [item.instance_id for item in targets_in_frame(VIEW.T_world_camera, space, CONFIG)] == [3, 2]
    narrow = replace(CONFIG, max_bearing_deg=5.0)
    assert [item.instance_id for item in targets_in_frame(VIEW.T_world_camera, space, narrow)] == [3]


def test_as_many_targets_as_requested_must_be_in_sight() -> None:
    space = bare_space(NEAR, FAR)
    near = space.targets[0]
    assert shows(VIEW, near, space, replace(CONFIG, min_targets=2))
    assert not shows(VIEW, near, space, replace(CONFIG, min_targets=3))
    hidden = bare_space(NEAR, FAR, *(("carton_600x400x400", (5.0, -3.35, z), np.pi / 2) for z in (0.2, 0.6)))
    assert shows(VIEW, hidden.targets[0], hidden, CONFIG)
    assert not shows(VIEW, hidden.targets[0], hidden, replace(CONFIG, min_targets=2))
    assert not shows(VIEW, hidden.targets[1], hidden, CONFIG)


def test_the_aim_counts_while_it_is_in_view_and_the_nearest_otherwise() -> None:
    space = bare_space(NEAR, FAR)
    near, far = space.targets
    assert target_in_view(VIEW, space, CONFIG) is near
    assert target_in_view(VIEW, space, CONFIG, aim=far) is far
    assert target_in_view(VIEW, space, replace(CONFIG, max_bearing_deg=5.0), aim=far) is near
    back = Viewpoint(level_camera(np.array([0.0, -4.0, 0.5]), np.pi))
    assert target_in_view(back, space, CONFIG, aim=far) is None
