"""How far from the surface that it hit a LiDAR may place a point: its noise law, from the contents of the manifest.

The check that uses it shares no code with the simulated sensor; the formulas are those of docs/lidar.md.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.stored.contents import LidarContents

_BIAS_SIGMAS = math.sqrt(3.0)
"""Constant errors of lasers are evenly spread, so that none goes beyond."""
SIGMAS = 6.0
"""Normal noise goes beyond this once in 500 million points."""
FARTHEST_START = 0.25
"""No laser of a known LiDAR starts farther from the origin of its frame (m); an HDL-64E's do by up to 0.22 m."""
_FARTHEST_AHEAD_DEG = 10.0
"""By which the lasers of a known LiDAR look beside its head at most, as an HDL-64E's do (deg)."""
_DARK, _WEAKEST = 0.1, 0.1
"""Remission to which ``dark_range`` belongs; relative power below which noise grows no more."""
# A beam is looked at in up to five places. The strongest names the point; the others, each within a pulse length of the
# next, draw it away from there by their mean: (0 + 1 + 2 + 3 + 4) / 5 pulse lengths at most.
_MIXED_PULSES = 2.0


@dataclass(frozen=True)
class LidarLaw(LidarContents):
    """The errors of one LiDAR; all zero where the recipe says nothing of them."""

    @classmethod
    def of(cls, lidar: LidarContents | None) -> Self:
        """Return the law of a dataset's main LiDAR."""
        return cls() if lidar is None else cls(**vars(lidar))

    @property
    def beam_radius(self) -> float:
        """Half angle of the beam across its wider side (rad)."""
        return 0.5e-3 * max(self.divergence_mrad)

    @property
    def mixing_reach(self) -> float:
        """How far a point that mixes surfaces may lie from the one that names it (m)."""
        return _MIXED_PULSES * self.pulse_length if self.beam_radius > 0 else 0.0

    @property
    def mixed_fraction(self) -> float:
        """Fraction of the gap between two beams that one covers: so often it meets what is narrower than the gap."""
        return min(self.beam_radius / math.radians(self.azimuth_step_deg), 1.0)

    @property
    def cycle_time(self) -> float:
        """Time between two firings of a laser (s)."""
        return self.azimuth_step_deg / 360.0 / self.turns_per_second

    @property
    def forward_time(self) -> float:
        """When in a sweep the head looks forward (s)."""
        first, last = self.azimuth_range_deg
        way = last if self.turns_clockwise else -first
        return max(way, 0.0) / 360.0 / self.turns_per_second

    @property
    def turns_clockwise(self) -> bool:
        """Whether the head turns from the left to the right when it looks forward."""
        return self.spin == "clockwise"

    @property
    def time_uncertainty(self) -> float:
        """By how much that may be wrong (s): a sweep of part of a turn waits for lasers that look ahead of the head."""
        first, last = self.azimuth_range_deg
        is_whole = last - first > 360.0 - self.azimuth_step_deg / 2.0
        return 0.0 if is_whole or self.motion == "ignored" else _FARTHEST_AHEAD_DEG / 360.0 / self.turns_per_second

    def noise_limit(
        self, distance: Float[np.ndarray, " n"], intensity: Float[np.ndarray, " n"]
    ) -> Float[np.ndarray, " n"]:
        """Return how far noise and steps may move points along their rays (m).

        Args:
            distance: Measured (m).
            intensity: Stored, 0-1; with the distance it says how weak the signal was.
        """
        near = self._limit(distance + FARTHEST_START, intensity)
        # A point that was measured too near had a weaker signal than its distance says.
        return self._limit(distance + FARTHEST_START + near, intensity)

    def _limit(self, distance: Float[np.ndarray, " n"], intensity: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
        sigma = np.full(len(distance), self.range_noise)
        if self.dark_range > 0:
            full = 255.0 if self.intensity_scale == "linear" else 100.0
            # The least reflectance that rounds to this intensity.
            reflectance = np.clip((255.0 * intensity - 0.5) / full * math.exp(-self.intensity_spread), 0.0, 1.0)
            falling = np.exp(-2.0 * self.extinction * (distance - self.dark_range))
            power = reflectance / _DARK * (self.dark_range / distance) ** 2 * falling
            sigma = np.hypot(sigma, self.range_noise_weak / np.maximum(power, _WEAKEST))
        return SIGMAS * sigma + _BIAS_SIGMAS * self.laser_bias + self.range_step / 2.0
