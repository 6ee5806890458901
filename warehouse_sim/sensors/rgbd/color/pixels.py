"""From light on the pixels (Bayer filter, noise) to the numbers that they give, and on to codes; and back to light."""

from collections.abc import Sequence
from functools import cache, lru_cache
from statistics import NormalDist
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float32, Int16, UInt8, UInt16

from warehouse_sim.color import linear_from_srgb, srgb_from_linear
from warehouse_sim.render.display import inverse_tone_map, tone_map
from warehouse_sim.sensors.rgbd.color.config import ColorConfig


def linear_light(rgb: UInt8[np.ndarray, "h w 3"]) -> Float32[np.ndarray, "h w 3"]:
    """Return the linear image values (1 = what just saturates at the exposure) that are shown as ``rgb``."""
    return cv2.LUT(rgb, _linear_of_code())


@cache
def _linear_of_code() -> Float32[np.ndarray, " 256"]:
    return inverse_tone_map(linear_from_srgb(np.arange(256) / 255.0)).astype(np.float32)


def add_noise(
    linear: Float32[np.ndarray, "*s"], rng: np.random.Generator, *, shot: float, read: float, gain: float
) -> Float32[np.ndarray, "*s"]:
    """Return ``linear`` with noise of variance ``gain shot x + gain^2 read``.

    EMVA 1288 release 4.0, section 2: shot noise is that of the electrons, of which a gain makes each brighter value out
    of fewer; read noise is amplified with them. In the form of Brooks et al. 2019, "Unprocessing images for learned raw
    denoising", ``x lambda_shot + lambda_read``, which finds 0.0001-0.012 for lambda_shot in photographs.

    Args:
        linear: Clean light (1 = saturation), >= 0.
        rng: Source of the noise.
        shot: Variance per linear value at gain 1.
        read: Variance at gain 1 that is always there.
        gain: Amplification over ISO 100, >= 1.
    """
    if shot == 0 and read == 0:
        return linear
    # Noise needs no finer draw than 256 equally likely Gaussian quantiles, which cost one byte each.
    draws = np.frombuffer(rng.bytes(linear.size), np.uint8).reshape(linear.shape)
    sigma = cv2.sqrt(linear * np.float32(gain * shot) + np.float32(gain * gain * read)).reshape(linear.shape)
    return linear + cv2.LUT(draws, _unit_quantiles()).reshape(linear.shape) * sigma


@cache
def _unit_quantiles() -> Float32[np.ndarray, " 256"]:
    values = np.array([NormalDist().inv_cdf((k + 0.5) / 256) for k in range(256)])
    return (values / values.std()).astype(np.float32)


def mosaic(linear: Float32[np.ndarray, "h w 3"]) -> Float32[np.ndarray, "h w"]:
    """Return what each pixel sees behind an RGGB filter: red in even columns of even rows."""
    seen = linear[..., 1].copy()
    seen[::2, ::2] = linear[::2, ::2, 0]
    seen[1::2, 1::2] = linear[1::2, 1::2, 2]
    return seen


_BETWEEN = np.array([0.5, 1.0, 0.5], np.float32)
"""Along rows and columns, this interpolates what every second pixel of every second row says."""


def demosaic(codes: UInt8[np.ndarray, "h w"]) -> UInt8[np.ndarray, "h w 3"]:
    """Return colours from a mosaic: green along edges, corrected by the other colour; red and blue by their difference.

    Adams and Hamilton 1997 (US 5,629,734). A line of one pixel stays whole and keeps its colour: of green alone both
    directions are as even there, and chance would decide between them.
    """
    height, width = codes.shape
    around = cv2.copyMakeBorder(codes, 2, 2, 2, 2, cv2.BORDER_REFLECT_101).astype(np.int16)
    green, missing = codes.astype(np.int16), np.zeros((2, height, width), np.int16)
    for start in (0, 1):

        def beside(down: int, right: int, start: int = start) -> Int16[np.ndarray, "hh ww"]:
            rows = slice(2 + start + down, 2 + height + down, 2)
            return around[rows, 2 + start + right : 2 + width + right : 2]

        options, changes = list[Int16[np.ndarray, "hh ww"]](), list[Int16[np.ndarray, "hh ww"]]()
        for down, right in ((0, 1), (1, 0)):
            before, after = beside(-down, -right), beside(down, right)
            bend = 2 * beside(0, 0) - beside(-2 * down, -2 * right) - beside(2 * down, 2 * right)
            options.append(2 * (before + after) + bend)
            changes.append(np.abs(before - after) + np.abs(bend))
        across, along = changes
        fourfold = np.where(across < along, options[0], np.where(along < across, options[1], sum(options) >> 1))
        site = slice(start, None, 2), slice(start, None, 2)
        green[site] = np.clip((fourfold + 2) >> 2, 0, 255)
        missing[start][site] = codes[site] - green[site]
    red, blue = (cv2.add(green, cv2.sepFilter2D(part, -1, _BETWEEN, _BETWEEN), dtype=cv2.CV_8U) for part in missing)
    return cv2.merge([red, green.astype(np.uint8), blue])


_LARGEST = 65535


def read_pixels(
    linear: Float32[np.ndarray, "h w 3"],
    factors: Sequence[Float32[np.ndarray, "..."]],
    config: ColorConfig,
    gain: float,
    rng: np.random.Generator,
) -> UInt8[np.ndarray, "h w 3"]:
    """Return the codes of an image: what its pixels see, with noise and in steps, and what the filter hides.

    Pixels see less red and blue than green; the channels' gains come after the noise. The renderer's display curve ends
    at saturation. Hidden colours are interpolated in codes, which costs a third of doing it in light.

    Args:
        linear: Light (1 = saturation of green at ISO 100).
        factors: On it, each of a shape that broadcasts to (h, w, 3).
        config: Noise, saturation, bits, filter.
        gain: Amplification over ISO 100.
        rng: Source of the noise.
    """
    sites = _filter_sites(config.bayer)
    gains = np.array([config.red_gain, 1.0, config.blue_gain], np.float32)
    light = mosaic(linear) if config.bayer else linear.copy()
    for factor in [*factors, *([] if (gains == 1.0).all() else [1.0 / gains])]:
        _scale(light, factor, sites)
    scale = config.noise_scale**2
    noisy = add_noise(light, rng, gain=gain, shot=scale * config.shot_noise, read=scale * config.read_noise)
    numbers = _converted(noisy, config)
    codes = np.empty(numbers.shape, np.uint8)
    for place, channel in sites:
        table = _code_of_number(config.saturation, config.black_level, float(gains[channel]))
        np.take(table, numbers[place], out=codes[place], mode="clip")
    return demosaic(codes) if config.bayer else codes


def noise_in_codes(config: ColorConfig, gain: float) -> float:
    """Return the standard deviation of the noise of a grey of 18 % of saturation, in codes of the image."""
    grey, scale = 0.18 * config.saturation, config.noise_scale**2
    sigma = np.sqrt(scale * (gain * config.shot_noise * grey + gain * gain * config.read_noise))
    table = _code_of_number(config.saturation, config.black_level, 1.0)
    per_light = (1.0 - config.black_level) / config.saturation * _LARGEST
    at = round(_LARGEST * config.black_level + grey * per_light)
    slope = (float(table[at + 1500]) - float(table[at - 1500])) / 3000.0
    return float(sigma * per_light * slope)


def _filter_sites(bayer: bool) -> list[tuple[Any, int]]:
    """Return the places of an array that see one channel, and which."""
    if not bayer:
        return [((..., channel), channel) for channel in range(3)]
    channels = [[0, 1], [1, 2]]
    return [((slice(v, None, 2), slice(u, None, 2)), channels[v][u]) for v in (0, 1) for u in (0, 1)]


def _scale(light: Float32[np.ndarray, "*s"], factor: Float32[np.ndarray, "..."], sites: list[tuple[Any, int]]) -> None:
    """Multiply what pixels see by a factor that broadcasts to (h, w, 3), in place."""
    if light.ndim == 3:
        np.multiply(light, factor, out=light)
    elif factor.ndim == 3 and factor.shape[2] == 1:
        np.multiply(light, factor[..., 0], out=light)
    else:
        for place, channel in sites:
            light[place] *= factor[channel] if factor.ndim == 1 else factor[place[0], :, channel]


def _converted(light: Float32[np.ndarray, "*s"], config: ColorConfig) -> UInt16[np.ndarray, "*s"]:
    """Return the converter's steps, in 16 bits; it saturates at both ends."""
    fraction, base = (1.0 - config.black_level) / config.saturation, config.black_level
    if config.bits == 16:
        if base == 0:
            return cv2.multiply(light, _LARGEST / config.saturation, dtype=cv2.CV_16U)
        return cv2.addWeighted(light, _LARGEST * fraction, light, 0.0, _LARGEST * base, dtype=cv2.CV_16U)
    most = 2**config.bits - 1
    steps = cv2.addWeighted(light, most * fraction, light, 0.0, most * base, dtype=cv2.CV_16U)
    np.minimum(steps, most, out=steps)
    return cv2.multiply(steps, _LARGEST / most, dtype=cv2.CV_16U)


@lru_cache(maxsize=16)
def _code_of_number(saturation: float, black_level: float, gain: float) -> UInt8[np.ndarray, " 65536"]:
    """Return the code of each number: black taken away, the channel's gain, the display curve up to saturation."""
    fraction = (np.arange(_LARGEST + 1) / _LARGEST - black_level) / (1.0 - black_level)
    linear = saturation * np.clip(gain * fraction, 0.0, 1.0)
    table = np.rint(255.0 * srgb_from_linear(tone_map(linear) / tone_map(np.array(saturation)))).astype(np.uint8)
    table.setflags(write=False)
    return table
