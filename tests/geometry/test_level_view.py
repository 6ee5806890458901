"""The level virtual camera, held against the plain rules of perspective."""

import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.level_view import level_view, levelled, reach
from warehouse_sim.geometry.pose import level_camera

KITTI = PinholeCamera.from_focal(1224, 370, 721.5377)
WIDE = PinholeCamera(1280, 720, 770.0, 770.0, 639.5, 359.5, Distortion(k1=-0.31, k2=0.115, k3=-0.0208))


def pose(pitch_deg: float, roll_deg: float = 0.0, yaw: float = 0.7) -> np.ndarray:
    return level_camera(np.array([1.0, -2.0, 3.0]), yaw, np.deg2rad(pitch_deg), np.deg2rad(roll_deg))


@pytest.mark.parametrize(("pitch_deg", "roll_deg"), [(-30, 3), (-12, 0), (5, -3), (0, 2), (-44, 0), (20, 10)])
def test_both_see_the_same_points_and_a_homography_leads_from_one_to_the_other(pitch_deg: int, roll_deg: int) -> None:
    T, rng = pose(pitch_deg, roll_deg), np.random.default_rng(0)
    camera, T_level = level_view(KITTI, T)
    u, v = rng.uniform(-0.5, 1223.5, 500), rng.uniform(-0.5, 369.5, 500)
    points = KITTI.rays_at(u, v) * rng.uniform(1.0, 20.0, (500, 1)) @ T[:3, :3].T + T[:3, 3]
    seen = (points - T_level[:3, 3]) @ T_level[:3, :3]
    assert (seen[:, 2] > 0).all()
    shown = camera.project(seen)
    assert (shown > -0.5 - 1e-6).all()
    assert (shown < [camera.width - 0.5 + 1e-6, camera.height - 0.5 + 1e-6]).all()
    # Four corners fix a homography, and it must hold for every other pixel.
    H = camera.K @ T_level[:3, :3].T @ T[:3, :3] @ np.linalg.inv(KITTI.K)
    mapped = np.column_stack([u, v, np.ones(500)]) @ H.T
    np.testing.assert_allclose(mapped[:, :2] / mapped[:, 2:], shown, atol=1e-6)


@pytest.mark.parametrize("camera", [KITTI, WIDE], ids=["pinhole", "lens"])
def test_no_row_or_column_is_to_spare(camera: PinholeCamera) -> None:
    T = pose(-20.0, 3.0)
    level, T_level = level_view(camera, T)
    assert level.distortion is None
    u, v = np.meshgrid(np.linspace(-0.5, camera.width - 0.5, 901), np.linspace(-0.5, camera.height - 0.5, 901))
    seen = level.project(camera.rays_at(u.ravel(), v.ravel()) @ (T_level[:3, :3].T @ T[:3, :3]).T)
    low, high = seen.min(axis=0), seen.max(axis=0)
    np.testing.assert_allclose(low, -0.5, atol=2e-2)
    assert (np.array([level.width, level.height]) - 0.5 - high < 1.02).all()
    assert (np.array([level.width, level.height]) - 0.5 - high > -1e-6).all()


@pytest.mark.parametrize("yaw", [-3.0, 0.4, 2.0])
def test_the_heading_of_a_camera_that_looks_straight_down_is_where_its_image_ends_above(yaw: float) -> None:
    ahead = levelled(pose(-90.0, yaw=yaw))[:3, 2]
    np.testing.assert_allclose(ahead, [np.cos(yaw), np.sin(yaw), 0.0], atol=1e-9)


def test_what_reaches_too_far_is_rejected_and_told() -> None:
    # The lower border of the image is arctan(185 / 721.5) = 14.4 deg below the axis.
    assert np.rad2deg(reach(KITTI, np.deg2rad(-40.0), 0.0)) == pytest.approx(54.38, abs=0.01)
    with pytest.raises(ValueError, match=r"the image reaches 60\.4 deg from the horizon; a level camera sees 60 deg"):
        level_view(KITTI, pose(-46.0))
    assert np.rad2deg(reach(KITTI, np.deg2rad(-90.0), 0.0)) > 90.0


def test_a_rolled_camera_reaches_farther_at_its_corners() -> None:
    straight, rolled = (reach(KITTI, np.deg2rad(-30.0), np.deg2rad(roll)) for roll in (0.0, 3.0))
    corner = np.array([1223.5 - KITTI.cx, 369.5 - KITTI.cy, KITTI.fx]) / KITTI.fx
    x, y = corner[0], corner[1]
    lower = np.sin(np.deg2rad(3.0)) * x + np.cos(np.deg2rad(3.0)) * y
    assert rolled == pytest.approx(np.arctan(lower) + np.deg2rad(30.0))
    assert rolled > straight
