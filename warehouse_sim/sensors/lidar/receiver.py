"""The receiver: which echoes it detects, with what range noise it measures them, and their intensity."""

import numpy as np
from jaxtyping import Bool, Float, Float32, Int32

from warehouse_sim.sensors.lidar.config import LidarConfig
from warehouse_sim.sensors.lidar.unit import LidarUnit

_DARK = 0.1
"""Remission for which data sheets state the shorter of their ranges."""
_BRIGHTEST_RETROREFLECTOR = 10.0
"""Remission of 1000 %, where the VLP-16's scale is taken to end."""


def relative_power(
    reflectance: Float[np.ndarray, " n"], distance: Float[np.ndarray, " n"], config: LidarConfig
) -> Float[np.ndarray, " n"]:
    """Return the received power, 1 where half of the pulses are detected; infinite for a LiDAR without dropout.

    ``P = rho cos(theta) exp(-2 a R) / R^2``, the LiDAR equation for a surface that fills the beam.

    Args:
        reflectance: ``rho cos(theta)``.
        distance: R (m), finite.
        config: Extinction a, and the range at which 10 % remission give 1.
    """
    if config.dark_range == 0:
        return np.full_like(distance, np.inf)
    limit = _DARK * np.exp(-2.0 * config.extinction * config.dark_range) / config.dark_range**2
    power = reflectance * distance.dtype.type(1.0 / limit) / np.square(np.maximum(distance, 1e-3))
    if config.extinction > 0:
        power *= np.exp(distance * distance.dtype.type(-2.0 * config.extinction))
    return power


def detection_probability(power: Float[np.ndarray, " n"], config: LidarConfig) -> Float[np.ndarray, " n"]:
    """Return how often an echo is detected: a sigmoid over the relative power, one half at 1."""
    with np.errstate(over="ignore"):
        return 1.0 / (1.0 + np.exp((1.0 - power) * power.dtype.type(1.0 / config.detection_width)))


def detected(
    power: Float32[np.ndarray, " n"], chance: Float32[np.ndarray, " n"], config: LidarConfig
) -> Bool[np.ndarray, " n"]:
    """Return which echoes are detected, given even numbers ``chance`` of 0-1."""
    return chance < detection_probability(power, config)


def range_sigma(power: Float[np.ndarray, " n"], config: LidarConfig) -> Float[np.ndarray, " n"]:
    """Return the standard deviation of the distance (m): ``sqrt(s^2 + (w / P)^2)``.

    Against a constant background the error of a pulse's time goes with the inverse of its signal-to-noise ratio.
    """
    weak = power.dtype.type(config.range_noise_weak) / np.maximum(power, power.dtype.type(0.1))
    return np.sqrt(power.dtype.type(config.range_noise**2) + weak * weak)


def quantised(distance: Float32[np.ndarray, " n"], step: float) -> Float32[np.ndarray, " n"]:
    """Return distances in whole steps (m); 0 = as they are."""
    return distance if step == 0 else np.rint(distance * np.float32(1.0 / step)) * np.float32(step)


def intensity_factor(
    distance: Float32[np.ndarray, " n"],
    ring: Int32[np.ndarray, " n"],
    config: LidarConfig,
    unit: LidarUnit | None,
    rng: np.random.Generator,
) -> Float32[np.ndarray, " n"]:
    """Return by what the intensities differ from the surfaces': gain of the laser, calibration, speckle.

    Args:
        distance: m.
        ring: Of the laser.
        config: How strong the speckle is.
        unit: Its gains and what its calibration leaves; None = none.
        rng: Of the speckle.
    """
    exponent = np.zeros_like(distance)
    if config.brightness.speckle > 0:
        rng.standard_normal(len(distance), np.float32, out=exponent)
        exponent *= np.float32(config.brightness.speckle)
    if unit is not None:
        exponent += unit.gain[ring]
        exponent += unit.residual_at(distance)
    return np.exp(exponent, out=exponent)


def intensity(reflectance: Float32[np.ndarray, " n"], config: LidarConfig) -> Float32[np.ndarray, " n"]:
    """Return the calibrated intensity, 0-1 in steps of 1/255.

    Calibration takes distance and extinction out. The scale ``diffuse100`` is that of the VLP-16's user manual: 0-100
    stand for diffuse surfaces of 0-100 %, 101-255 for retroreflectors.
    """
    if config.intensity_scale == "linear":
        codes = 255.0 * np.minimum(reflectance, 1.0)
    else:
        beyond = np.clip((reflectance - 1.0) / (_BRIGHTEST_RETROREFLECTOR - 1.0), 0.0, 1.0)
        codes = 100.0 * np.minimum(reflectance, 1.0) + 155.0 * beyond
    return np.rint(codes).astype(np.float32) * np.float32(1.0 / 255.0)
