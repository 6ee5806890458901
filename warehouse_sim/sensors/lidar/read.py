"""One sweep of a LiDAR: fire, listen, measure, pack."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from jaxtyping import Float32, Int

from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan
from warehouse_sim.sensors.ego_motion import EgoMotion
from warehouse_sim.sensors.lidar.config import LidarConfig
from warehouse_sim.sensors.lidar.footprint import footprint_echoes
from warehouse_sim.sensors.lidar.receiver import detected, intensity, quantised, range_sigma, relative_power
from warehouse_sim.sensors.lidar.sweep import Sweep, columns, make_sweep
from warehouse_sim.sensors.view import SensorView


@dataclass(frozen=True)
class Lidar:
    """The sensor ``lidar``."""

    reads_light: ClassVar[bool] = False

    config: LidarConfig = field(default_factory=LidarConfig)
    """Lasers, beam and receiver."""

    def read(self, view: SensorView, rng: np.random.Generator) -> LidarScan:
        """Return the sweep that looks forward at the moment of the view."""
        return scan(view.caster, self.config, view.T_world_sensor, rng, view.ego_motion)


def scan(
    raycaster: RayCaster,
    config: LidarConfig,
    T_world_lidar: Transform,
    rng: np.random.Generator,
    motion: EgoMotion | None = None,
) -> LidarScan:
    """Return one sweep; intensity is the material's remission times the cosine of incidence, calibrated.

    Args:
        raycaster: The scene.
        config: Lasers, beam and receiver.
        T_world_lidar: Pose of the LiDAR frame (x forward, y left, z up) when it looks forward.
        rng: Source of dropout and range noise.
        motion: How the vehicle moves; used unless ``config.motion`` is ``ignored``.
    """
    sweep = make_sweep(config)
    moving = None if config.motion == "ignored" else motion
    origins, directions = world_rays(sweep, T_world_lidar, moving)
    echoes, _ = footprint_echoes(raycaster, config, sweep, origins, directions)
    count = len(directions)
    chance, unit = rng.random(count, np.float32), rng.standard_normal(count, np.float32)
    # Only what came back is worked on, in the order in which it was fired.
    beams = sweep.firing_order[np.isfinite(echoes.distance)[sweep.firing_order]]
    distance, reflectance = echoes.distance[beams], echoes.reflectance[beams]
    power = relative_power(reflectance, distance, config)
    measured = quantised(distance + unit[beams] * range_sigma(power, config), config.range_step)
    kept = (measured >= config.min_range) & (measured <= config.max_range)
    kept &= detected(power, chance[beams], config)
    beams, measured = beams[kept], measured[kept]
    if moving is not None and config.motion == "deskewed":
        points = _in_frame(_along(origins, directions, beams, measured), T_world_lidar)
    else:
        points = _along(sweep.origins, sweep.directions, beams, measured)
    return LidarScan(
        points=points,
        intensity=intensity(reflectance[kept], config),
        instance_ids=echoes.instance_ids[beams],
        ring=sweep.ring[beams],
        time=sweep.time[beams],
    )


def world_rays(
    sweep: Sweep, T_world_lidar: Transform, motion: EgoMotion | None = None
) -> tuple[Float32[np.ndarray, "n 3"], Float32[np.ndarray, "n 3"]]:
    """Return origins (m) and unit directions of a sweep's rays in the world.

    Args:
        sweep: The rays.
        T_world_lidar: Pose of the LiDAR when it looks forward.
        motion: How it moves meanwhile; None = not at all.
    """
    rotation, position = T_world_lidar[:3, :3].astype(np.float32), T_world_lidar[:3, 3].astype(np.float32)
    # einsum, not @: a product this small is not worth waking the threads of a linear algebra library.
    directions = np.einsum("in,ji->jn", sweep.directions.T, rotation).T
    origins = (np.einsum("in,ji->jn", sweep.origins.T, rotation) + position[:, None]).T
    if motion is None:
        return origins, directions
    since = sweep.time - np.float32(sweep.forward_time)
    return motion.moved(origins, since), motion.turned(directions, since)


def _along(
    origins: Float32[np.ndarray, "n 3"],
    directions: Float32[np.ndarray, "n 3"],
    beams: Int[np.ndarray, " m"],
    distance: Float32[np.ndarray, " m"],
) -> Float32[np.ndarray, "m 3"]:
    """Return the points on some rays; worked on in columns, as the rays are stored."""
    points = columns(directions, beams).T
    points *= distance
    points += columns(origins, beams).T
    return np.ascontiguousarray(points.T)


def _in_frame(points: Float32[np.ndarray, "n 3"], T_world_lidar: Transform) -> Float32[np.ndarray, "n 3"]:
    """Return world points in the LiDAR frame."""
    rotation, position = T_world_lidar[:3, :3].astype(np.float32), T_world_lidar[:3, 3].astype(np.float32)
    return np.einsum("ni,ij->nj", points - position, rotation)
