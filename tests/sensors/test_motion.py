"""How a vehicle moves, and the cameras on it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import CAMERA, plane
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z
from warehouse_sim.render.conformance.scenes import at, rack_wall
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import Viewpoint
from warehouse_sim.sensors.motion import EgoMotion, camera_motion
from warehouse_sim.sensors.rgbd.color.camera import vignetting_factor
from warehouse_sim.sensors.rgbd.depth.edges import baseline_shadow
from warehouse_sim.sensors.rgbd.depth.time_of_flight import cosine_of_view
from warehouse_sim.sensors.surfaces import camera_rays, facing_cosine, see_surfaces


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


LENS = replace(CAMERA, distortion=Distortion(k1=-0.3, k2=0.1, p1=0.002, p2=-0.001))


def test_angles_are_those_of_the_lens() -> None:
    rays = LENS.rays()
    length = np.linalg.norm(rays, axis=-1)
    np.testing.assert_allclose(camera_rays(LENS), rays, atol=1e-6)
    np.testing.assert_allclose(cosine_of_view(LENS), 1.0 / length, atol=1e-6)
    seen = plane(2.0, 30.0, LENS)
    assert seen.normals is not None
    normal = seen.normals[0, 0].astype(float)
    np.testing.assert_allclose(facing_cosine(seen.normals, LENS), np.abs(rays @ normal) / length, atol=1e-6)
    np.testing.assert_allclose(vignetting_factor(LENS, 1.0)[..., 0], length**-4.0, atol=1e-6)


def test_the_shadow_of_a_board_behind_a_lens_is_what_rays_to_the_second_eye_do_not_reach() -> None:
    baseline, near, far = 0.1, 1.0, 2.0
    rays = LENS.rays()
    on_board = (np.abs(rays[..., 0] * near) < 0.1) & (np.abs(rays[..., 1] * near) < 0.2)
    depth = np.where(on_board, near, far)
    shadow = baseline_shadow((LENS.fx * baseline / depth).astype(np.float32), LENS)
    points = rays * depth[..., None]
    crossing = points + (np.array([baseline, 0.0, 0.0]) - points) * ((far - near) / far)
    hidden = ~on_board & (np.abs(crossing[..., 0]) < 0.1) & (np.abs(crossing[..., 1]) < 0.2)
    u, v = np.moveaxis(LENS.project(points - [baseline, 0.0, 0.0]), -1, 0)
    hidden |= (u < -0.5) | (v < -0.5) | (v > LENS.height - 0.5)
    assert hidden.mean() > 0.05
    assert (shadow == hidden).mean() > 0.985


def test_materials_are_those_that_the_pixels_show() -> None:
    scene = rack_wall()
    T = scene.viewpoints[0].T_world_camera
    surfaces = see_surfaces(scene, RayCaster(scene), LENS, T)
    rays = LENS.rays()[::2, ::2].reshape(-1, 3) @ T[:3, :3].T
    hits = RayCaster(scene).cast(np.broadcast_to(T[:3, 3], rays.shape), rays)
    np.testing.assert_allclose(surfaces.remission[::2, ::2].ravel(), hits.remission, atol=1e-6)
