import numpy as np

from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z
from warehouse_sim.schema import Viewpoint
from warehouse_sim.sensors.motion import camera_motion


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
