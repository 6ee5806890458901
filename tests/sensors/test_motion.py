"""How a vehicle moves, and the cameras on it."""

import numpy as np
import pytest

from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z
from warehouse_sim.render.conformance.scenes import at
from warehouse_sim.schema import Viewpoint
from warehouse_sim.sensors.motion import EgoMotion, camera_motion


def test_a_straight_drive_moves_points_and_turns_nothing() -> None:
    motion = EgoMotion(np.array([2.0, 0.0, 0.0]), 0.0, np.zeros(3))
    time = np.array([-0.5, 0.0, 0.25])
    points = np.tile([1.0, 2.0, 3.0], (3, 1))
    moved, turned = motion.carried(points, points, time)
    np.testing.assert_allclose(moved, points + np.outer(time, [2.0, 0, 0]), atol=1e-6)
    np.testing.assert_array_equal(turned, points.astype(np.float32))


def test_a_turn_follows_its_circle() -> None:
    """1 m/s along x at 0.5 rad/s: a circle of radius 2 about (0, 2), a quarter of which takes pi seconds."""
    motion = EgoMotion(np.array([1.0, 0.0, 0.0]), 0.5, np.zeros(3))
    time = np.array([np.pi, 2 * np.pi, 4 * np.pi])
    ahead = np.tile([0.3, 0.0, 1.5], (3, 1))
    pivot, turned = motion.carried(np.zeros((3, 3)), ahead, time)
    np.testing.assert_allclose(pivot, [[2, 2, 0], [0, 4, 0], [0, 0, 0]], atol=1e-6)
    np.testing.assert_allclose(turned[:2], [[0, 0.3, 1.5], [-0.3, 0, 1.5]], atol=1e-6)
    moved = motion.carried(ahead, ahead, time)[0]
    np.testing.assert_allclose(moved, [[2, 2.3, 1.5], [-0.3, 4, 1.5], [0.3, 0, 1.5]], atol=1e-6)


def test_a_viewpoint_says_how_its_vehicle_moves() -> None:
    standing = Viewpoint(at(1, 2, 3))
    assert EgoMotion.of(standing) is None
    driving = Viewpoint(at(1, 2, 3), T_world_vehicle=at(4, 5, 0), velocity=(0.5, 0.0, 0.0), yaw_rate=0.1)
    motion = EgoMotion.of(driving)
    assert motion is not None
    assert motion.pivot.tolist() == [4.0, 5.0, 0.0]
    assert motion.velocity == pytest.approx([0.5, 0, 0])
    assert motion.yaw_rate == 0.1


def test_a_camera_moves_with_its_vehicle() -> None:
    """Facing along +y, one metre ahead of a vehicle that turns to the left: the camera drifts along -x, its left."""
    T_world_vehicle = make_transform(rotation_z(np.pi / 2), np.array([3.0, 4.0, 0.0]))
    T_world_camera = level_camera(np.array([3.0, 5.0, 1.5]), np.pi / 2)
    motion = camera_motion(
        Viewpoint(T_world_camera, T_world_vehicle=T_world_vehicle, velocity=(0.0, 2.0, 0.0), yaw_rate=0.5)
    )
    np.testing.assert_allclose(motion.velocity, [-0.5, 0.0, 2.0], atol=1e-12)
    np.testing.assert_allclose(motion.rotation, [0.0, -0.5, 0.0], atol=1e-12)


def test_a_camera_that_nothing_carries_turns_about_itself() -> None:
    T_world_camera = level_camera(np.array([3.0, 5.0, 1.5]), 0.0)
    motion = camera_motion(Viewpoint(T_world_camera, velocity=(0.0, 1.0, 0.0), yaw_rate=0.3))
    np.testing.assert_allclose(motion.velocity, [-1.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(motion.rotation, [0.0, -0.3, 0.0], atol=1e-12)
