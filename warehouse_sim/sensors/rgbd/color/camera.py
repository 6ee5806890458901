"""A colour camera: light in, bytes out."""

import numpy as np
from jaxtyping import Float32, UInt8

from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.capture import Capture
from warehouse_sim.sensors.rgbd.color.config import IDEAL_COLOR, ColorConfig
from warehouse_sim.sensors.rgbd.color.develop import compressed, develop
from warehouse_sim.sensors.rgbd.color.flicker import flicker_factor
from warehouse_sim.sensors.rgbd.color.light_curve import linear_light
from warehouse_sim.sensors.rgbd.color.motion_blur import blur_by_motion
from warehouse_sim.sensors.rgbd.color.optics import add_glare, spread_points, vignetting_factor
from warehouse_sim.sensors.rgbd.color.pixels import noise_in_codes, read_pixels


def read_color(
    buffers: RenderBuffers, capture: Capture, config: ColorConfig, rng: np.random.Generator
) -> UInt8[np.ndarray, "h w 3"]:
    """Return the image that a colour camera stores of a clean rendering.

    In this order: motion and rolling shutter, glare, point spread, errors of exposure and white balance, flicker,
    vignetting, noise at the gain that the exposure value asks for, saturation, the converter's steps, the colour
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
    factors = _factors(light.shape[0], config, shutter, rng)
    if config.vignetting > 0:
        factors.append(vignetting_factor(capture.camera, config.vignetting))
    rgb = read_pixels(light, factors, config, gain, rng)
    rgb = develop(rgb, noise=noise_in_codes(config, gain), denoise=config.denoise, sharpen=config.sharpen)
    return rgb if config.jpeg_quality is None else compressed(rgb, config.jpeg_quality)


def _factors(
    rows: int, config: ColorConfig, shutter: float, rng: np.random.Generator
) -> list[Float32[np.ndarray, "..."]]:
    """Return the factors of one image: on its channels, and on its rows where the light flickers."""
    exposure, red, blue = rng.standard_normal(3)
    tint = np.exp(config.white_balance_error * np.array([red, 0.0, blue]))
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
