from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.sensors.targets import capture_of, plane
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.sensors.motion import Motion
from warehouse_sim.sensors.rgbd.color import IDEAL_COLOR, ColorConfig, read_color
from warehouse_sim.sensors.rgbd.color.camera import flicker_factor
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


# What the camera leaves of a texture, by cross spectra: noise that it adds is not coherent and does not count.


SIZE = 256
ENERGY_CAMERA = PinholeCamera.from_focal(SIZE, SIZE, 800.0)


def texture(sigma: float) -> np.ndarray:
    """Return grey codes whose power falls as f^-2.5 above 2 cycles an image, as that of photographs."""
    frequency = np.hypot(np.fft.fftfreq(SIZE)[:, None], np.fft.fftfreq(SIZE)[None])
    white = np.fft.fft2(np.random.default_rng(5).standard_normal((SIZE, SIZE)))
    shaped = np.fft.ifft2(white * np.maximum(frequency, 2 / SIZE) ** -1.25).real
    codes = 118 + sigma * (shaped - shaped.mean()) / shaped.std()
    return np.repeat(np.clip(np.rint(codes), 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def energy_kept(config: ColorConfig, ev: float, sigma: float = 12.0) -> float:
    """Return the energy of the part of the image that follows the clean one, over the clean one's, in 0.1-0.4 c/px."""
    clean = texture(sigma)
    buffers = replace(plane(2.0, camera=ENERGY_CAMERA, code=118), rgb=clean)
    stored = read_color(buffers, replace(capture_of(ENERGY_CAMERA), exposure_ev=ev), config, np.random.default_rng(1))
    x, y = (np.fft.fft2(image[..., 1].astype(float) - image[..., 1].mean()) for image in (clean, stored))
    frequency = np.hypot(np.fft.fftfreq(SIZE)[:, None], np.fft.fftfreq(SIZE)[None])
    kept = total = 0.0
    for low in np.arange(0.1, 0.4, 0.02):
        ring = (frequency >= low) & (frequency < low + 0.02)
        power = (np.abs(x[ring]) ** 2).sum()
        kept += np.abs((y[ring] * x[ring].conj()).sum()) ** 2 / power
        total += power
    return float(kept / total)


def test_a_point_spread_leaves_the_energy_of_its_transfer_function() -> None:
    """A Gaussian at whole pixels has the sum of exp(-2 pi^2 sigma^2 (f - k)^2) over k (Poisson's summation)."""
    axis = np.fft.fftfreq(SIZE)
    frequency = np.hypot(axis[:, None], axis[None])
    band = (frequency >= 0.1) & (frequency < 0.4)
    power = frequency[band] ** -2.5
    for sigma in (0.4, 0.5):
        line = sum(np.exp(-2 * (np.pi * sigma * (axis - k)) ** 2) for k in range(-3, 4))
        transfer = (line[:, None] * line[None] / line[0] ** 2)[band]
        expected = (power * transfer**2).sum() / power.sum()
        assert energy_kept(replace(IDEAL_COLOR, blur_px=sigma), 9.0) == pytest.approx(expected, abs=0.03)


@pytest.mark.parametrize("ev", [9.0, 7.0])
def test_the_camera_keeps_most_of_the_energy_of_fine_detail(ev: float) -> None:
    """At most 15 % is lost, or added by sharpening."""
    stored = replace(ColorConfig(), exposure_error=0.0, flicker=0.0, vignetting=0.0)
    assert 0.85 < energy_kept(stored, ev) < 1.15
    assert energy_kept(replace(stored, denoise=2.0), ev) < 0.4


@pytest.mark.parametrize("shutter", [0.0004, 0.003, 0.013])
def test_each_row_sees_the_mean_of_the_light_while_it_is_exposed(shutter: float) -> None:
    """Against a sum over 20,000 moments of each row's exposure."""
    seen = flicker_factor(9, depth=0.3, frequency=100.0, shutter=shutter, readout=0.03, phase=0.2)[:, 0, 0]
    for row, factor in enumerate(seen):
        middle = ((row + 0.5) / 9 - 0.5) * 0.03
        moments = middle + shutter * ((np.arange(20_000) + 0.5) / 20_000 - 0.5)
        light = 1.0 + 0.3 * np.cos(2 * np.pi * (100.0 * moments + 0.2))
        assert factor == pytest.approx(light.mean(), abs=1e-5)


def test_exposures_of_whole_periods_see_nothing() -> None:
    seen = flicker_factor(100, depth=0.5, frequency=100.0, shutter=0.010, readout=0.03, phase=0.1)
    np.testing.assert_allclose(seen, 1.0, atol=1e-6)


def test_a_global_shutter_has_no_bands_and_a_rolling_one_three_of_them() -> None:
    still = flicker_factor(300, depth=0.2, frequency=100.0, shutter=0.001, readout=0.0, phase=0.4)
    assert np.ptp(still) == 0
    bands = flicker_factor(300, depth=0.2, frequency=100.0, shutter=0.001, readout=0.03, phase=0.4)[:, 0, 0]
    spectrum = np.abs(np.fft.rfft(bands - bands.mean()))
    assert spectrum.argmax() == 3
