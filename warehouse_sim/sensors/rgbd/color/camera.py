"""A colour camera: light in, bytes out."""

from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32, UInt8

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.capture import Capture
from warehouse_sim.sensors.rgbd.color.bayer import demosaic, mosaic
from warehouse_sim.sensors.rgbd.color.config import IDEAL_COLOR, ColorConfig
from warehouse_sim.sensors.rgbd.color.light_curve import display_codes, linear_light
from warehouse_sim.sensors.rgbd.color.motion_blur import blur_by_motion
from warehouse_sim.sensors.rgbd.color.noise import add_noise


def read_color(
    buffers: RenderBuffers, capture: Capture, config: ColorConfig, rng: np.random.Generator
) -> UInt8[np.ndarray, "h w 3"]:
    """Return the image that a colour camera takes of a clean rendering.

    In this order: motion blur, errors of exposure and white balance, vignetting, shot and read noise at the gain that
    the exposure value asks for, the colour filter, the display curve, JPEG.

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
    if config.motion_blur:
        light = blur_by_motion(light, buffers.depth, capture.camera, capture.motion, shutter)
    light = light * _balance(config, rng)
    if config.vignetting > 0:
        light *= vignetting_factor(capture.camera, config.vignetting)
    noise = {"shot": config.noise_scale**2 * config.shot_noise, "read": config.noise_scale**2 * config.read_noise}
    if config.bayer:
        light = demosaic(add_noise(mosaic(light), rng, gain=gain, **noise))
    else:
        light = add_noise(light, rng, gain=gain, **noise)
    rgb = display_codes(light)
    return rgb if config.jpeg_quality is None else _compressed(rgb, config.jpeg_quality)


def _balance(config: ColorConfig, rng: np.random.Generator) -> Float32[np.ndarray, "3"]:
    """Return the factors on red, green and blue."""
    exposure, red, blue = rng.standard_normal(3)
    tint = np.exp(config.white_balance_error * np.array([red, 0.0, blue]))
    return (2.0 ** (config.exposure_error * exposure) * tint).astype(np.float32)


@lru_cache(maxsize=8)
def vignetting_factor(camera: PinholeCamera, share: float) -> Float32[np.ndarray, "h w 1"]:
    """Return the light that reaches each pixel relative to the axis: cos^4 of the angle to it, softened."""
    if camera.distortion is None:
        x = (np.arange(camera.width) - camera.cx) / camera.fx
        y = ((np.arange(camera.height) - camera.cy) / camera.fy)[:, None]
    else:
        x, y, _ = np.moveaxis(camera.rays(), -1, 0)
    cosine4 = (1.0 + x * x + y * y) ** -2.0
    factor = (1.0 - share * (1.0 - cosine4)).astype(np.float32)[..., None]
    factor.setflags(write=False)
    return factor


def _compressed(rgb: UInt8[np.ndarray, "h w 3"], quality: int) -> UInt8[np.ndarray, "h w 3"]:
    """Return the image after JPEG."""
    _, data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, quality])
    return cv2.cvtColor(cv2.imdecode(data, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
