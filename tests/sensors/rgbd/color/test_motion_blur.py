from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.sensors.targets import plane
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.sensors.motion import Motion
from warehouse_sim.sensors.rgbd.color.optics import blur_by_motion, image_flow

CAMERA = PinholeCamera.from_focal(120, 90, 100.0)
RNG = np.random.default_rng(4)


LENS = replace(CAMERA, distortion=Distortion(k1=-0.3, k2=0.1, p1=0.002))


@pytest.mark.parametrize("camera", [CAMERA, LENS], ids=["pinhole", "lens"])
def test_the_flow_is_that_of_moved_and_projected_points(camera: PinholeCamera) -> None:
    depth = RNG.uniform(1.0, 6.0, (90, 120)).astype(np.float32)
    motion = Motion(np.array([0.3, -0.2, 1.5]), np.array([0.1, -0.4, 0.2]))
    points, dt = camera.unproject(depth.astype(float)), 1e-5
    moved = points - dt * (motion.velocity + np.cross(np.broadcast_to(motion.rotation, points.shape), points))
    expected = (camera.project(moved) - camera.project(points)) / dt
    np.testing.assert_allclose(image_flow(depth, camera, motion), expected, rtol=1e-3, atol=2e-2)


def test_an_edge_is_spread_over_the_way_that_it_takes() -> None:
    """Sideways at 2 m/s, 10 ms, 2 m away, f = 500 px: 5 px."""
    camera = PinholeCamera.from_focal(120, 90, 500.0)
    light = np.zeros((90, 120, 3), np.float32)
    light[:, 60:] = 1.0
    motion = Motion(velocity=np.array([2.0, 0.0, 0.0]))
    blurred = blur_by_motion(light, plane(2.0, camera=camera).depth, camera, motion, 0.010)
    profile = blurred[45, :, 0]
    rising = np.flatnonzero((profile > 0.01) & (profile < 0.99))
    assert 4 <= len(rising) <= 6
    assert profile[57:63].mean() == pytest.approx(0.5, abs=0.02)
    assert (np.diff(profile) >= -1e-6).all()
    assert profile[:56].max() < 1e-6


def test_what_is_far_blurs_by_turning_only() -> None:
    light = RNG.uniform(0.0, 1.0, (90, 120, 3)).astype(np.float32)
    nothing = np.zeros((90, 120), np.float32)
    assert blur_by_motion(light, nothing, CAMERA, Motion(np.array([9.0, 0, 9.0])), 0.01) is light
    turned = blur_by_motion(light, nothing, CAMERA, Motion(rotation=np.array([0, 3.0, 0])), 0.01)
    assert turned.std() < 0.8 * light.std()


def test_blocks_that_look_at_few_places_are_as_blurred_as_ones_that_look_at_many() -> None:
    """A floor that comes nearer below: ways of 0.4 to 12 px, against the mean over 65 places of every way."""
    camera = PinholeCamera.from_focal(400, 300, 400.0)
    light = cv2.GaussianBlur(RNG.uniform(0.0, 1.0, (300, 400, 3)).astype(np.float32), (0, 0), 1.5)
    depth = np.broadcast_to(np.geomspace(40.0, 1.5, 300, dtype=np.float32)[:, None], (300, 400)).copy()
    motion = Motion(np.array([1.5, 0.2, 1.0]), np.array([0.0, 0.02, 0.0]))
    shutter = 0.02
    flow = shutter * image_flow(depth, camera, motion)
    length = np.linalg.norm(flow, axis=-1)
    assert length.min() < 1.0
    assert length.max() > 8.0
    places = np.stack(np.meshgrid(np.arange(400.0), np.arange(300.0)), axis=-1).astype(np.float32)
    fractions = (np.arange(65) + 0.5) / 65 - 0.5
    exact = np.mean(
        [
            cv2.remap(
                light, places + np.float32(fraction) * flow, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
            )
            for fraction in fractions
        ],
        axis=0,
    )
    error = np.abs(blur_by_motion(light, depth, camera, motion, shutter) - exact)
    unblurred = np.abs(light - exact)
    assert error.mean() < 0.05 * unblurred.mean()
    assert error.max() < 2.0 / 255.0
    # Nothing tells where blocks meet.
    step = np.abs(np.diff(error, axis=1))
    assert step[:, 127].mean() < 1.5 * step.mean()


def test_a_rolling_shutter_leans_what_passes() -> None:
    """Sideways at 2 m/s, 2 m away, f = 500 px: 500 px/s, so 15 px from the first row to the last one in 30 ms."""
    camera = PinholeCamera.from_focal(160, 90, 500.0)
    light = np.zeros((90, 160, 3), np.float32)
    light[:, 80:] = 1.0
    motion = Motion(velocity=np.array([2.0, 0.0, 0.0]))
    rolled = blur_by_motion(light, plane(2.0, camera=camera).depth, camera, motion, 0.0, 0.030)
    edge = 160 - rolled[..., 0].sum(axis=1)  # columns that are dark
    time = ((np.arange(90) + 0.5) / 90 - 0.5) * 0.030
    # The camera moves right, so what is seen moves left with time.
    np.testing.assert_allclose(edge, 80 - 500 * time, atol=0.15)


def test_a_rolling_shutter_and_blur_are_the_mean_over_each_rows_own_exposure() -> None:
    camera = PinholeCamera.from_focal(160, 90, 500.0)
    light = cv2.GaussianBlur(RNG.uniform(0.0, 1.0, (90, 160, 3)).astype(np.float32), (0, 0), 2.0)
    motion = Motion(velocity=np.array([1.0, 0.4, 0.0]))
    depth = plane(2.0, camera=camera).depth
    flow = image_flow(depth, camera, motion)
    time = ((np.arange(90) + 0.5) / 90 - 0.5) * 0.030
    places = np.stack(np.meshgrid(np.arange(160.0), np.arange(90.0)), axis=-1)
    exact = np.zeros_like(light)
    for fraction in (np.arange(65) + 0.5) / 65 - 0.5:
        moments = (time + fraction * 0.010)[:, None, None]
        exact += cv2.remap(light, (places - moments * flow).astype(np.float32), None, cv2.INTER_LINEAR) / 65
    rolled = blur_by_motion(light, depth, camera, motion, 0.010, 0.030)
    assert np.abs(rolled - exact)[20:-20, 20:-20].max() < 0.02
