from dataclasses import replace

import numpy as np

from tests.sensors.targets import CAMERA, plane
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.render.conformance.scenes import rack_wall
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.sensors.rgbd.color.camera import vignetting_factor
from warehouse_sim.sensors.rgbd.depth.edges import baseline_shadow
from warehouse_sim.sensors.rgbd.depth.time_of_flight import cosine_of_view
from warehouse_sim.sensors.surfaces import camera_rays, facing_cosine, see_surfaces

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
