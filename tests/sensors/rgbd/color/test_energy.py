"""What the camera leaves of a texture, by cross spectra: noise that it adds is not coherent and does not count."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import capture_of, plane
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.sensors.rgbd.color import IDEAL_COLOR, ColorConfig, read_color

SIZE = 256
CAMERA = PinholeCamera.from_focal(SIZE, SIZE, 800.0)


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
    buffers = replace(plane(2.0, camera=CAMERA, code=118), rgb=clean)
    stored = read_color(buffers, replace(capture_of(CAMERA), exposure_ev=ev), config, np.random.default_rng(1))
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
    """At most 15 % is lost in good light; dim light takes more gain, and noise that is removed takes detail along."""
    stored = replace(ColorConfig(), exposure_error=0.0, flicker=0.0, vignetting=0.0)
    assert energy_kept(stored, ev) > (0.85 if ev > 8.0 else 0.75)
    assert energy_kept(replace(stored, denoise=2.0, sharpen=0.7), ev) < 0.4
