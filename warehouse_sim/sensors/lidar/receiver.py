"""The receiver and its unit: which echoes it detects, range noise and intensity, constant errors, and blooming."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, Int32

from warehouse_sim.render.raycaster import RayHits
from warehouse_sim.schema.things import RETROREFLECTIVE
from warehouse_sim.sensors.lidar.config import LidarConfig
from warehouse_sim.sensors.lidar.echo import Echoes
from warehouse_sim.sensors.lidar.lasers import LASERS
from warehouse_sim.sensors.lidar.sweep import Sweep, columns

_FARTHEST, _STEP = 512.0, 0.25
"""Reach and step of the table of what calibration leaves (m)."""
_OCTAVES = (2.0, 3.3)
"""Over how many doublings of the distance the two waves of that residual repeat; no source."""


@dataclass(frozen=True, eq=False)
class LidarUnit:
    """What is constant in a unit, by ring from the topmost down."""

    bias: Float32[np.ndarray, " k"]
    """Of the distances of each laser (m)."""
    gain: Float32[np.ndarray, " k"]
    """Logarithm of the factor of the intensities of each laser."""
    residual: Float32[np.ndarray, " n"]
    """Logarithm of a factor of the intensities, by distance in steps of 0.25 m."""

    @classmethod
    def sample(cls, config: LidarConfig, rng: np.random.Generator) -> "LidarUnit":
        """Draw a unit. Biases are even, so that none is beyond sqrt(3) of its standard deviation."""
        lasers = len(LASERS[config.model]().elevation)
        wide = np.sqrt(3.0)
        bias, gain = rng.uniform(-wide, wide, (2, lasers))
        phases = rng.uniform(0.0, 2.0 * np.pi, len(_OCTAVES))
        octave = np.log2(np.maximum(np.arange(0.0, _FARTHEST, _STEP), _STEP))
        turns = 2.0 * np.pi * octave / np.array(_OCTAVES)[:, None]
        waves = np.cos(turns + phases[:, None]).sum(axis=0)
        return cls(
            (bias[:: config.every_nth_beam] * config.laser_bias).astype(np.float32),
            (gain[:: config.every_nth_beam] * config.brightness.laser_gain).astype(np.float32),
            (waves * config.brightness.range_residual).astype(np.float32),
        )

    def residual_at(self, distance: Float32[np.ndarray, " n"]) -> Float32[np.ndarray, " n"]:
        """Return the logarithm of the factor that calibration leaves at distances (m)."""
        step = np.minimum(distance * np.float32(1.0 / _STEP), np.float32(len(self.residual) - 1)).astype(np.int32)
        return self.residual[step]


_BRIGHTNESS = 10.0
"""Remission of a retroreflector: over 1000 % in SICK's table."""
_FAINTEST = 0.02
"""Remission below which what leaks is left out."""


def add_bloom(echoes: Echoes, hits: RayHits, sweep: Sweep, config: LidarConfig) -> None:
    """Put the leaked echo of retroreflectors in place of weaker echoes; no object's id goes with it.

    Args:
        echoes: Of the sweep's beams; changed.
        hits: What the beams' axes meet.
        sweep: The grid that they form.
        config: How far light leaks.
    """
    if config.bloom_deg == 0:
        return
    sources = np.flatnonzero(hits.remission >= RETROREFLECTIVE)
    if len(sources) == 0:
        return
    beams, beside = _pairs(sources, sweep, config)
    cosine = np.einsum("in,in->n", columns(sweep.directions, beams).T, columns(sweep.directions, beside).T)
    angle = np.degrees(np.arccos(np.minimum(cosine, 1.0)))
    leaked = np.float32(_BRIGHTNESS) * np.power(np.float32(10.0), np.float32(-2.0 / config.bloom_deg) * angle)
    distance = hits.distance[beams]
    own = echoes.reflectance[beside] / np.square(echoes.distance[beside])  # nothing: 0 / inf
    wins = (leaked > _FAINTEST) & (leaked / np.square(distance) > own) & (hits.remission[beside] < RETROREFLECTIVE)
    beams, beside, leaked = beams[wins], beside[wins], leaked[wins]
    order = np.argsort(leaked / np.square(distance[wins]), kind="stable")  # the strongest is written last
    beams, beside, leaked = beams[order], beside[order], leaked[order]
    echoes.distance[beside] = hits.distance[beams]
    echoes.reflectance[beside] = leaked
    echoes.instance_ids[beside] = 0


def _pairs(
    sources: Int[np.ndarray, " n"], sweep: Sweep, config: LidarConfig
) -> tuple[Int[np.ndarray, " m"], Int[np.ndarray, " m"]]:
    """Return each retroreflecting beam with each beam that may be near enough."""
    rings, count = sweep.shape
    reach = config.bloom_deg / 2.0 * np.log10(_BRIGHTNESS / _FAINTEST)
    elevation = np.degrees(np.arcsin(sweep.directions[::count, 2]))
    spacing = np.median(np.abs(np.diff(elevation))) if rings > 1 else reach
    down = int(min(reach / max(float(spacing), 1e-3), rings - 1))
    aside = int(min(reach / config.azimuth_step_deg, count // 2))
    steps = np.stack(np.meshgrid(np.arange(-down, down + 1), np.arange(-aside, aside + 1)), axis=-1).reshape(-1, 2)
    ring = sources[:, None] // count + steps[:, 0]
    column = sources[:, None] % count + steps[:, 1]
    if sweep.closed:
        column = column % count
    inside = (ring >= 0) & (ring < rings) & (column >= 0) & (column < count)
    return np.broadcast_to(sources[:, None], inside.shape)[inside], (ring * count + column)[inside]


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
