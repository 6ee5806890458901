"""A ring of ultrasonic rangers around a vehicle: each tells how far away the nearest thing in its cone is."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from warehouse_sim.ranges import Range, ranged
from warehouse_sim.schema import ChannelReading
from warehouse_sim.sensors.view import SensorView

_RAYS = 61
"""Rays by which a cone is sampled."""


@dataclass(frozen=True)
@ranged
class UltrasonicRing:
    """Rangers that look outwards at equal angles, the first one forward."""

    rangers: Annotated[int, Range(1, 64)] = 8
    """Number of rangers, 1-64."""
    half_angle_deg: Annotated[float, Range(0, 60, "deg")] = 15.0
    """Half opening angle of each cone (deg), 0-60."""
    farthest: Annotated[float, Range(0.1, 20, "m")] = 4.0
    """Farthest echo that is heard (m), 0.1-20; farther away, or nothing there, reads 0."""
    sigma: Annotated[float, Range(0, 1, "m")] = 0.01
    """Standard deviation of a reading (m), 0-1."""

    reads_light = False

    def read(self, view: SensorView, rng: np.random.Generator) -> ChannelReading:
        """Return ``distance`` (rangers,) in metres, 0 where there is no echo."""
        azimuth = 2 * np.pi * np.arange(self.rangers) / self.rangers
        rays = np.concatenate([_cone(angle, np.deg2rad(self.half_angle_deg)) for angle in azimuth])
        T = view.T_world_sensor
        hits = view.caster.cast(np.tile(T[:3, 3], (len(rays), 1)), rays @ T[:3, :3].T)
        nearest = hits.distance.reshape(self.rangers, _RAYS).min(axis=1)
        heard = nearest <= self.farthest
        noisy = np.abs(np.where(heard, nearest, 0.0) + rng.normal(0.0, self.sigma, self.rangers))
        return ChannelReading({"distance": np.where(heard, noisy, 0.0).astype(np.float32)}, units={"distance": "m"})


def _cone(azimuth: float, half_angle: float) -> np.ndarray:
    """Return unit vectors (n x 3, x forward, y left, z up) spread evenly over a cone, by a golden spiral."""
    step = np.arange(_RAYS) / max(_RAYS - 1, 1)
    off, around = half_angle * np.sqrt(step), np.pi * (3.0 - np.sqrt(5.0)) * np.arange(_RAYS)
    forward, left, up = np.cos(off), np.sin(off) * np.cos(around), np.sin(off) * np.sin(around)
    c, s = np.cos(azimuth), np.sin(azimuth)
    return np.stack([c * forward - s * left, s * forward + c * left, up], axis=1)
