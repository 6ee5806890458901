"""Where a LiDAR may place a point: its noise law, the beams beside it, and the vehicle's motion in its sweep.

The check that uses it shares no code with the simulated sensor; the formulas are those of docs/lidar.md.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from jaxtyping import Bool, Float, Int, Int32

from warehouse_sim.dataset.stored.contents import LidarContents
from warehouse_sim.dataset.stored.observation_record import RecordedObservation
from warehouse_sim.geometry.pose import Transform, transform_points

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


_NOTHING = np.int32(-1)
_SIDES = ((0, -1), (0, 1), (-1, 0), (1, 0))


class SweepGrid:
    """A sweep's points on a grid of rings and azimuths.

    Args:
        ring: Of each point, 0 = topmost.
        column: Of each point, along the ring.
        ids: Instance id of each point.
    """

    def __init__(
        self, ring: Int[np.ndarray, " n"], column: Int[np.ndarray, " n"], ids: Int32[np.ndarray, " n"]
    ) -> None:
        self._ring, self._column = ring + 1, column
        self._ids = np.full((int(ring.max(initial=0)) + 3, int(column.max(initial=0)) + 1), _NOTHING)
        self._ids[self._ring, column] = ids

    @classmethod
    def of(
        cls,
        points: Float[np.ndarray, "n 3"],
        ids: Int32[np.ndarray, " n"],
        beams: tuple[Int[np.ndarray, " n"], Float[np.ndarray, " n"]],
        law: LidarLaw,
    ) -> Self:
        """Put points of the LiDAR's frame (m) on the grid.

        A ring fires once a cycle, but its laser may look beside the head: by how much shows in its points.

        Args:
            points: In the LiDAR's frame (m).
            ids: Instance id of each.
            beams: Ring and time (s) of each.
            law: The LiDAR's.
        """
        ring, time = beams
        if len(points) == 0:
            return cls(ring, ring, ids)
        count = max(round(360.0 / law.azimuth_step_deg), 1)
        # The first laser of a cycle fires with it, but for rounding.
        cycle = np.floor(time / law.cycle_time + 1e-3).astype(np.int64)
        if law.turns_clockwise:
            cycle = -cycle
        azimuth = np.degrees(np.arctan2(points[:, 1], points[:, 0])) - law.azimuth_range_deg[0]
        ahead = (azimuth / law.azimuth_step_deg - cycle + count / 2) % count - count / 2
        order = np.argsort(ring.astype(np.int16), kind="stable")  # of 16 bits, as those are sorted in one pass
        for chosen in np.split(order, np.flatnonzero(np.diff(ring[order])) + 1):
            cycle[chosen] += round(float(np.median(ahead[chosen])))
        return cls(ring, cycle % count, ids)

    def beside_another(self, points: Int[np.ndarray, " m"], instance_id: int) -> Bool[np.ndarray, " m"]:
        """Return which of an object's points have a beam beside, above or below them that did not meet the object."""
        ring, column = self._ring[points], self._column[points]
        there = [self._ids[ring + down, (column + along) % self._ids.shape[1]] for down, along in _SIDES]
        return (np.array(there) != instance_id).any(axis=0)


Points = Float[np.ndarray, "n 3"]


def in_world(
    points: Points,
    time: Float[np.ndarray, " n"],
    T_world_lidar: Transform,
    law: LidarLaw,
    observation: RecordedObservation,
) -> tuple[Points, Points]:
    """Return points and the starts of their beams in the world (m).

    Args:
        points: As stored, in the LiDAR's frame (m).
        time: Of each, since the sweep began (s).
        T_world_lidar: Pose of the LiDAR when it looks forward.
        law: Says whether the vehicle's motion bent the sweep, and whether it was put right.
        observation: How the vehicle moved.
    """
    hits = transform_points(T_world_lidar, points)
    starts = np.broadcast_to(T_world_lidar[:3, 3], hits.shape)
    if law.motion == "ignored":
        return hits, starts
    since = time - law.forward_time
    moved = _carried(starts, since, observation)
    return (_carried(hits, since, observation) if law.motion == "raw" else hits), moved


def _carried(points: Points, since: Float[np.ndarray, " n"], observation: RecordedObservation) -> Points:
    """Return world points that the vehicle carries, each at its time: turned about its origin, which drives an arc."""
    carrier = observation.T_world_camera if observation.T_world_vehicle is None else observation.T_world_vehicle
    pivot, rate = carrier[:3, 3], observation.yaw_rate
    # A complex number in place of the plane: dx/dt = v exp(i w t).
    velocity = complex(*observation.velocity[:2])
    turn = np.exp(1j * rate * since)
    way = velocity * (since if rate == 0 else (turn - 1.0) / (1j * rate))
    plane = (points[:, 0] - pivot[0] + 1j * (points[:, 1] - pivot[1])) * turn + way + complex(*pivot[:2])
    return np.stack([plane.real, plane.imag, points[:, 2] + observation.velocity[2] * since], axis=1)
