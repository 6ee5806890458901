"""A colour camera: light in, bytes out; flicker of the mains before, denoising, sharpening and JPEG after.

Before light falls on the pixels, lens and housing spread it, and so does motion.
"""

from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32, Int16, UInt8

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.motion import Motion
from warehouse_sim.sensors.pixel_rays import pixel_stretch, pixel_tangents
from warehouse_sim.sensors.rgbd.color.config import IDEAL_COLOR, ColorConfig
from warehouse_sim.sensors.rgbd.color.pixels import linear_light, noise_in_codes, read_pixels
from warehouse_sim.sensors.view import Capture
from warehouse_sim.sensors.white_balance import balancing

_WIDE, _NARROW = (1.0 / 20.0, 16), (1.0 / 120.0, 4)
"""Halo of the lens, and the one close about lamps and windows: standard deviation over the image's width, and edge (px)
of the blocks in which light is spread, as it has no finer detail there. No source: priors."""
_WIDE_FRACTION, _NARROW_FRACTION = 0.35, 0.25
"""Of the scattered light, what the halos get; the rest is even. No source: priors."""


def spread_points(linear: Float32[np.ndarray, "h w 3"], sigma_px: float) -> Float32[np.ndarray, "h w 3"]:
    """Return the image behind a Gaussian point spread of ``sigma_px``; its light is kept away from the border."""
    if sigma_px == 0:
        return linear
    reach = 2 * max(1, round(2.5 * sigma_px)) + 1
    return cv2.GaussianBlur(linear, (reach, reach), sigma_px, borderType=cv2.BORDER_REPLICATE)


def add_glare(linear: Float32[np.ndarray, "h w 3"], fraction: float) -> Float32[np.ndarray, "h w 3"]:
    """Return the image with ``fraction`` of its light scattered: evenly, and as two halos about what is bright.

    ISO 9358 calls the fraction veiling glare (index); photographic lenses have 1-5 %. Brightness clips only afterwards,
    so that a door in the sun veils what is before it. The sum of the light stays, but for the halos beyond the border.
    """
    if fraction == 0:
        return linear
    height, width = linear.shape[:2]
    wide, narrow = _halo(linear, *_WIDE), _halo(linear, *_NARROW)
    even = (1.0 - _WIDE_FRACTION - _NARROW_FRACTION) * wide.mean(axis=(0, 1))
    veil = (fraction * (_WIDE_FRACTION * wide + even)).astype(np.float32)
    veil = cv2.resize(veil, narrow.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    veil = cv2.addWeighted(veil, 1.0, narrow, fraction * _NARROW_FRACTION, 0.0)
    veil = cv2.resize(veil, (width, height), interpolation=cv2.INTER_LINEAR)
    return cv2.addWeighted(linear, 1.0 - fraction, veil, 1.0, 0.0)


def _halo(linear: Float32[np.ndarray, "h w 3"], spread: float, block: int) -> Float32[np.ndarray, "r c 3"]:
    """Return the light of blocks of ``block`` pixels, spread over ``spread`` of the width."""
    height, width = linear.shape[:2]
    size = (max(width // block, 1), max(height // block, 1))
    coarse = cv2.resize(linear, size, interpolation=cv2.INTER_AREA)
    return cv2.GaussianBlur(coarse, (0, 0), max(spread * size[0], 0.5), borderType=cv2.BORDER_REFLECT)


@lru_cache(maxsize=8)
def vignetting_factor(camera: PinholeCamera, fraction: float) -> Float32[np.ndarray, "h w 1"]:
    """Return the light that reaches each pixel relative to the axis: cos^4 of the angle to it, softened."""
    if camera.distortion is None:
        x = (np.arange(camera.width) - camera.cx) / camera.fx
        y = ((np.arange(camera.height) - camera.cy) / camera.fy)[:, None]
    else:
        x, y, _ = np.moveaxis(camera.rays(), -1, 0)
    cosine4 = (1.0 + x * x + y * y) ** -2.0
    factor = (1.0 - fraction * (1.0 - cosine4)).astype(np.float32)[..., None]
    factor.setflags(write=False)
    return factor


_LEAST_PX = 0.5
"""Blur that cannot be seen."""
_SPACING_PX = 1.0
"""From one place to the next on the longest way of a block."""
_MOST_TAPS = 13
_BLOCK_PX = 128
"""Edge of the blocks of pixels that look at as many places as their own longest way requires."""


def blur_by_motion(
    linear: Float32[np.ndarray, "h w 3"],
    depth: Float32[np.ndarray, "h w"],
    camera: PinholeCamera,
    motion: Motion,
    shutter: float,
    readout: float = 0.0,
) -> Float32[np.ndarray, "h w 3"]:
    """Return the mean of the light along each pixel's way through the image, a few places per way.

    A rolling shutter takes rows one after the other: each looks at the way's part of its own time. Each pixel follows
    its own surface; what passes before it at the edge of a nearer thing is left out. Ways are long where things are
    near: each block of pixels looks at as many places as its own longest way requires.

    Args:
        linear: Light at the middle of the exposure of the middle row.
        depth: True z-depth (m), 0 = infinitely far.
        camera: Intrinsics.
        motion: Of the camera.
        shutter: For how long the shutter is open (s).
        readout: From the first row's exposure to the last one's (s); 0 = all at once.
    """
    if not motion.velocity.any() and not motion.rotation.any():
        return linear
    rate = image_flow(depth, camera, motion)
    u, v = rate[..., 0], rate[..., 1]
    square = u * u + v * v
    if square.max() * max(shutter, readout / 2) ** 2 < _LEAST_PX**2:
        return linear
    time = ((np.arange(camera.height, dtype=np.float32) + 0.5) / camera.height - 0.5) * np.float32(readout)
    blurred = np.empty_like(linear)
    for top in range(0, camera.height, _BLOCK_PX):
        for left in range(0, camera.width, _BLOCK_PX):
            block = slice(top, top + _BLOCK_PX), slice(left, left + _BLOCK_PX)
            fastest = float(np.sqrt(square[block].max()))
            # What a row sees at its time was at the middle row's time where the way came from.
            late = time[block[0], None, None] * -rate[block] if readout * fastest > _LEAST_PX else None
            flow = rate[block] * np.float32(shutter)
            blurred[block] = _mean_along(linear, flow, late, (left, top), shutter * fastest)
    return blurred


def _mean_along(
    linear: Float32[np.ndarray, "h w 3"],
    flow: Float32[np.ndarray, "b c 2"],
    late: Float32[np.ndarray, "b c 2"] | None,
    corner: tuple[int, int],
    longest: float,
) -> Float32[np.ndarray, "b c 3"]:
    """Return the mean of the light along the ways of a block of pixels; ``flow`` is used up.

    Args:
        linear: The whole image.
        flow: Of the block's pixels while the shutter is open (px).
        late: From each pixel to the middle of its way (px); None = it is the middle.
        corner: Column and row of the block's first pixel.
        longest: Length of its longest way (px).
    """
    height, width = flow.shape[:2]
    left, top = corner
    if longest < _LEAST_PX and late is None:
        return linear[top : top + height, left : left + width]
    taps = int(np.clip(np.ceil(longest / _SPACING_PX) + 1, 3, _MOST_TAPS)) if longest >= _LEAST_PX else 1
    flow *= np.float32(1.0 / taps)
    place = flow * np.float32((1 - taps) / 2)
    place[..., 0] += np.arange(left, left + width, dtype=np.float32)
    place[..., 1] += np.arange(top, top + height, dtype=np.float32)[:, None]
    if late is not None:
        place += late
    total = np.zeros((height, width, 3), np.float32)
    for _ in range(taps):
        coarse, fine = cv2.convertMaps(place, None, cv2.CV_16SC2)  # 1/32 px, and faster than an exact map
        total += cv2.remap(linear, coarse, fine, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        place += flow
    total *= np.float32(1.0 / taps)
    return total


def image_flow(
    depth: Float32[np.ndarray, "h w"], camera: PinholeCamera, motion: Motion
) -> Float32[np.ndarray, "h w 2"]:
    """Return how fast each pixel's surface, at rest in the world, moves in the image (px/s).

    Longuet-Higgins & Prazdny 1980, "The interpretation of a moving retinal image".

    Args:
        depth: True z-depth (m), 0 = infinitely far.
        camera: Intrinsics.
        motion: Of the camera.
    """
    x, y = pixel_tangents(camera)
    vx, vy, vz = (np.float32(value) for value in motion.velocity)
    wx, wy, wz = (np.float32(value) for value in motion.rotation)
    near = np.divide(np.float32(1.0), depth, out=np.zeros_like(depth), where=depth > 0)
    turned = wx * y - wy * x
    flow = np.empty((*depth.shape, 2), np.float32)
    flow[..., 0] = (x * vz - vx) * near - (wy - wz * y) + x * turned
    flow[..., 1] = (y * vz - vy) * near - (wz * x - wx) + y * turned
    if camera.distortion is not None:
        flow = np.einsum("hwij,hwj->hwi", pixel_stretch(camera), flow)
    flow[..., 0] *= np.float32(camera.fx)
    flow[..., 1] *= np.float32(camera.fy)
    return flow


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
