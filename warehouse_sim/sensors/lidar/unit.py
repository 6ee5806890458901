"""One unit of a LiDAR: constant errors that differ from laser to laser and from unit to unit."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32

from warehouse_sim.sensors.lidar.config import LidarConfig
from warehouse_sim.sensors.lidar.lasers import LASERS

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
