"""A spinning LiDAR: beams on a table of elevations, one sweep from one place."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float32

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan

# Velodyne HDL-64E: two blocks of 32 lasers, the upper one a third of a degree apart, the lower one half a degree;
# the span +2.0 to -24.9 deg is that of the S3 data sheet.
_HDL64E_ELEVATIONS_DEG = (*np.linspace(2.0, -8.33, 32), *np.linspace(-8.83, -24.9, 32))


@dataclass(frozen=True)
class LidarConfig:
    """A LiDAR with the beams of an HDL-64E, or some of them."""

    azimuth_step_deg: float = 0.1728
    """Angle between shots (deg), > 0; 0.1728 is an HDL-64E at 10 turns a second."""
    azimuth_range_deg: tuple[float, float] = (-180.0, 180.0)
    """First and last azimuth (deg), 0 = forward, positive = left, within -180 to 180."""
    every_nth_beam: int = 1
    """Keep each n-th of the 64 beams, >= 1."""
    min_range: float = 0.9
    """Nearest distance that is returned (m), >= 0."""
    max_range: float = 120.0
    """Farthest distance that is returned (m), > min_range."""
    range_noise: float = 0.02
    """Standard deviation of the distance (m), >= 0; the HDL-64E's data sheet says 2 cm."""

    def __post_init__(self) -> None:
        first, last = self.azimuth_range_deg
        if self.azimuth_step_deg <= 0:
            raise ValueError(f"azimuth_step_deg must be positive, found {self.azimuth_step_deg}")
        if not -180 <= first < last <= 180:
            raise ValueError(f"azimuth_range_deg must rise within -180 to 180, found {first}, {last}")
        if self.every_nth_beam < 1:
            raise ValueError(f"every_nth_beam must be at least 1, found {self.every_nth_beam}")
        if self.max_range <= self.min_range:
            raise ValueError(f"max_range must exceed min_range {self.min_range}, found {self.max_range}")
        if self.range_noise < 0:
            raise ValueError(f"range_noise must not be negative, found {self.range_noise}")


def scan(raycaster: RayCaster, config: LidarConfig, T_world_lidar: Transform, rng: np.random.Generator) -> LidarScan:
    """Return one sweep; intensity is the material's remission times the cosine of incidence, at most 1.

    Args:
        raycaster: The scene.
        config: Beams and noise.
        T_world_lidar: Pose of the LiDAR frame (x forward, y left, z up).
        rng: Source of the range noise.
    """
    directions = beam_directions(config)
    # einsum, not @: a product this small is not worth waking the threads of a linear algebra library.
    in_world = np.einsum("ni,ji->nj", directions, T_world_lidar[:3, :3].astype(np.float32))
    hits = raycaster.cast(np.broadcast_to(T_world_lidar[:3, 3], in_world.shape), in_world)
    noise = rng.standard_normal(len(directions), dtype=np.float32) * np.float32(config.range_noise)
    measured = hits.distance + noise
    kept = np.flatnonzero((measured >= config.min_range) & (measured <= config.max_range))
    cosine = np.abs(np.einsum("ij,ij->i", hits.normals[kept], in_world[kept]))
    rings = np.arange(len(directions)) % _beam_count(config)
    return LidarScan(
        points=directions[kept] * measured[kept, None],
        intensity=np.minimum(hits.remission[kept] * cosine, np.float32(1.0)),
        instance_ids=hits.instance_ids[kept],
        ring=rings[kept].astype(np.int32),
    )


@cache
def beam_directions(config: LidarConfig) -> Float32[np.ndarray, "n 3"]:
    """Return unit directions in the LiDAR frame in firing order: all beams of one azimuth, then the next azimuth."""
    elevation = np.deg2rad(np.asarray(_HDL64E_ELEVATIONS_DEG)[:: config.every_nth_beam])
    first, last = config.azimuth_range_deg
    # A full turn must not fire twice in the direction where it closes.
    azimuth = np.deg2rad(
        np.arange(first, min(last, first + 360.0 - config.azimuth_step_deg / 2), config.azimuth_step_deg)
    )
    az, el = np.meshgrid(azimuth, elevation, indexing="ij")
    unit = np.stack([np.cos(el) * np.cos(az), np.cos(el) * np.sin(az), np.sin(el)], axis=-1)
    unit = unit.reshape(-1, 3).astype(np.float32)
    unit.setflags(write=False)
    return unit


def _beam_count(config: LidarConfig) -> int:
    return len(_HDL64E_ELEVATIONS_DEG[:: config.every_nth_beam])
