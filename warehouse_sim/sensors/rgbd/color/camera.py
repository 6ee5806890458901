"""A colour camera: light in, bytes out; flicker of the mains before, denoising, sharpening and JPEG after."""

import cv2
import numpy as np
from jaxtyping import Float32, Int16, UInt8

from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.color.config import IDEAL_COLOR, ColorConfig
from warehouse_sim.sensors.rgbd.color.optics import add_glare, blur_by_motion, spread_points, vignetting_factor
from warehouse_sim.sensors.rgbd.color.pixels import linear_light, noise_in_codes, read_pixels
from warehouse_sim.sensors.view import Capture
from warehouse_sim.sensors.white_balance import balancing


def flicker_factor(
    rows: int, *, depth: float, frequency: float, shutter: float, readout: float, phase: float
) -> Float32[np.ndarray, "h 1 1"]:
    """Return the light of each row relative to its mean: that of ``1 + depth cos(2 pi f t)`` over the exposure.

    The mean over an exposure T of a cosine is the cosine at its middle times sin(pi f T) / (pi f T): times of whole
    periods see nothing. A depth of 0.08 at 100 Hz is where IEEE Std 1789-2015 ends low risk (0.08 % per hertz).

    Args:
        rows: Of the image.
        depth: Of the modulation, 0-1.
        frequency: Of the light (Hz).
        shutter: For how long each row is exposed (s).
        readout: From the first row's exposure to the last one's (s); 0 = all at once.
        phase: Of the light at the middle of the exposure of the middle row, in periods.
    """
    time = ((np.arange(rows) + 0.5) / rows - 0.5) * readout
    seen = depth * np.sinc(frequency * shutter) * np.cos(2.0 * np.pi * (frequency * time + phase))
    return (1.0 + seen).astype(np.float32)[:, None, None]


_FINE, _COARSE = (5, 5), (13, 13)
"""Pixels of the Gaussians that tell fine detail from what is under it, and coarser detail."""
_COARSE_NOISE = 0.4
"""Noise in coarser detail over that of a pixel: 0.2 of white noise, more as the colour filter's is interpolated."""
_COLOR, _NOISY_COLOR = (7, 7), (15, 15)
"""The same for colour differences, which eyes and JPEG see coarsely, and where much noise is removed:"""
_NOISY = 2.0
"""from this threshold on (codes)."""
_FALSE_COLOR = 5
"""Pixels of the median that takes the colours of the filter's pattern off thin lines."""


def develop(
    rgb: UInt8[np.ndarray, "h w 3"], *, noise: float, denoise: float, sharpen: float
) -> UInt8[np.ndarray, "h w 3"]:
    """Return the image with its noise cored and its finest detail amplified, as the processors of cameras do.

    Brightness is split into its mean over a few pixels and what differs from it, finely and coarsely. Of the
    differences what is below the noise is removed (non-negative garrote, Gao 1998: edges stay as they are), and the
    fine rest amplified (unsharp masking). What is left are blotches of some pixels, as in real images, and a median
    filter does not remove them. Colour differences are smoothed.

    Args:
        rgb: Codes.
        noise: Standard deviation of noise in them.
        denoise: Threshold over ``noise``; 0 leaves all.
        sharpen: Fraction of the remaining detail that is added once more.
    """
    if denoise == 0 and sharpen == 0:
        return rgb
    brightness, red, blue = cv2.split(cv2.cvtColor(rgb, cv2.COLOR_RGB2YCrCb))
    base = cv2.GaussianBlur(brightness, _FINE, 0)
    kept = _kept(brightness, base, denoise * noise, 1.0 + sharpen)
    if denoise > 0:
        under = cv2.GaussianBlur(base, _COARSE, 0)
        base = cv2.add(under, _kept(base, under, _COARSE_NOISE * denoise * noise, 1.0), dtype=cv2.CV_8U)
        # Lines a pixel wide are blue or orange as they fall on the filter; a median (Freeman 1988) drops them.
        size = _COLOR if denoise * noise < _NOISY else _NOISY_COLOR
        red, blue = (cv2.GaussianBlur(cv2.medianBlur(color, _FALSE_COLOR), size, 0) for color in (red, blue))
    return cv2.cvtColor(cv2.merge([cv2.add(base, kept, dtype=cv2.CV_8U), red, blue]), cv2.COLOR_YCrCb2RGB)


def compressed(rgb: UInt8[np.ndarray, "h w 3"], quality: int) -> UInt8[np.ndarray, "h w 3"]:
    """Return the image after JPEG."""
    _, data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, quality])
    return cv2.cvtColor(cv2.imdecode(data, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


def _kept(
    image: UInt8[np.ndarray, "h w"], mean: UInt8[np.ndarray, "h w"], threshold: float, amplification: float
) -> Int16[np.ndarray, "h w"]:
    """Return what remains of how an image differs from its local mean; it ends at half of all codes."""
    detail = cv2.addWeighted(image, 1.0, mean, -1.0, 128.0)
    return cv2.LUT(detail, _detail_table(threshold, amplification))


def _detail_table(threshold: float, amplification: float) -> Int16[np.ndarray, " 256"]:
    """Return what remains of differences of -128 to 127."""
    difference = np.arange(-128.0, 128.0)
    size = np.maximum(np.abs(difference), 1e-9)
    kept = difference * np.maximum(1.0 - np.square(threshold / size), 0.0)
    return np.rint(amplification * kept).astype(np.int16)


def read_color(
    buffers: RenderBuffers, capture: Capture, config: ColorConfig, rng: np.random.Generator
) -> UInt8[np.ndarray, "h w 3"]:
    """Return the image that a colour camera stores of a clean rendering.

    In this order: motion and rolling shutter, glare, point spread, errors of exposure and white balance, flicker,
    vignetting, noise at the gain that the exposure value requires, saturation, the converter's steps, the colour
    filter, the channels' gains, the display curve, removal of noise, sharpening, JPEG.

    Args:
        buffers: Clean colours, and the depth that decides how they move.
        capture: Camera, exposure and motion.
        config: Settings.
        rng: Source of all errors.
    """
    if config == IDEAL_COLOR:
        return buffers.rgb
    shutter, gain = config.shutter_and_gain(capture.exposure_ev)
    light = linear_light(buffers.rgb)
    if config.motion_blur or config.rolling_shutter_ms > 0:
        readout = config.rolling_shutter_ms / 1000.0
        exposed = shutter if config.motion_blur else 0.0
        light = blur_by_motion(light, buffers.depth, capture.camera, capture.motion, exposed, readout)
    light = spread_points(add_glare(light, config.glare), config.blur_px)
    factors = _factors(light.shape[0], capture, config, shutter, rng)
    if config.vignetting > 0:
        factors.append(vignetting_factor(capture.camera, config.vignetting))
    rgb = read_pixels(light, factors, config, gain, rng)
    rgb = develop(rgb, noise=noise_in_codes(config, gain), denoise=config.denoise_at(gain), sharpen=config.sharpen)
    return rgb if config.jpeg_quality is None else compressed(rgb, config.jpeg_quality)


def _factors(
    rows: int, capture: Capture, config: ColorConfig, shutter: float, rng: np.random.Generator
) -> list[Float32[np.ndarray, "..."]]:
    """Return the factors of one image: on its channels, and on its rows where the light flickers."""
    exposure, red, blue = rng.standard_normal(3)
    tint = np.exp(config.white_balance_error * np.array([red, 0.0, blue]))
    tint = tint * balancing(capture.light, config.auto_white_balance)
    balance = (2.0 ** (config.exposure_error * exposure) * tint).astype(np.float32)
    if config.flicker == 0:
        return [balance]
    flicker = flicker_factor(
        rows,
        depth=config.flicker,
        frequency=config.flicker_hz,
        shutter=shutter,
        readout=config.rolling_shutter_ms / 1000.0,
        phase=rng.spawn(1)[0].random(),  # a stream of its own: without flicker the noise stays as it was
    )
    return [balance, flicker]
