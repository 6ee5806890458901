"""One sweep of a LiDAR: fire, listen, measure, pack."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from jaxtyping import Float32, Int, Int32

from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.render.raycaster import RayCaster, RayHits
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.schema import LidarScan
from warehouse_sim.sensors.film import FilmSight
from warehouse_sim.sensors.lidar.config import LidarConfig
from warehouse_sim.sensors.lidar.echo import Echoes
from warehouse_sim.sensors.lidar.finishes import Finishes, finishes_of
from warehouse_sim.sensors.lidar.footprint import see_sweep
from warehouse_sim.sensors.lidar.receiver import (
    LidarUnit,
    add_bloom,
    detected,
    intensity,
    intensity_factor,
    quantised,
    range_sigma,
    relative_power,
)
from warehouse_sim.sensors.lidar.sweep import Sweep, columns, make_sweep
from warehouse_sim.sensors.motion import EgoMotion
from warehouse_sim.sensors.view import SensorView


@dataclass(frozen=True)
class Lidar:
    """The sensor ``lidar``."""

    reads_light: ClassVar[bool] = False

    config: LidarConfig = field(default_factory=LidarConfig)
    """Lasers, beam and receiver."""

    def read(self, view: SensorView, rng: np.random.Generator) -> LidarScan:
        """Return the sweep that looks forward at the moment of the view.

        All sweeps of a scene are of one unit, and see each surface alike; other scenes have other units.
        """
        scene, config = view.scene, self.config
        of_scene = scene_rng(scene.seed, scene.scene_index, "lidar surfaces")
        of_unit = scene_rng(scene.seed, scene.scene_index, f"lidar unit {view.name}")
        return scan(
            view.caster,
            config,
            view.T_world_sensor,
            rng,
            view.ego_motion,
            unit=LidarUnit.sample(config, of_unit),
            finishes=finishes_of(scene, view.caster.materials, config.brightness, of_scene),
            film=view.film if config.film else None,
        )


def scan(
    raycaster: RayCaster,
    config: LidarConfig,
    T_world_lidar: Transform,
    rng: np.random.Generator,
    motion: EgoMotion | None = None,
    *,
    unit: LidarUnit | None = None,
    finishes: Finishes | None = None,
    film: FilmSight | None = None,
) -> LidarScan:
    """Return one sweep.

    Args:
        raycaster: The scene.
        config: Lasers, beam and receiver.
        T_world_lidar: Pose of the LiDAR frame (x forward, y left, z up) when it looks forward.
        rng: Source of dropout, range noise, phase and speckle.
        motion: How the vehicle moves; used unless ``config.motion`` is ``ignored``.
        unit: The unit's constant errors; None = it has none.
        finishes: Gloss, grain and spread of the materials; None = each is matt, even and as its name says.
        film: The scene's film; None = there is none.
    """
    sweep = make_sweep(config)
    count = len(sweep.directions)
    chance, normal = rng.random(count, np.float32), rng.standard_normal(count, np.float32)
    T_lidar_head = _turned(config, rng)
    T_world_head = T_world_lidar if T_lidar_head is None else T_world_lidar @ T_lidar_head
    moving = None if config.motion == "ignored" else motion
    origins, directions = world_rays(sweep, T_world_head, moving)
    seen = see_sweep(raycaster, config, sweep, origins, directions, finishes, film)
    add_bloom(seen.echoes, seen.hits, sweep, config)
    reader = _Reader(config, sweep, seen.hits, origins, directions, rng, unit, finishes)
    beams, measured, codes, ids = reader.measure(seen.echoes, chance, normal)
    if seen.others is not None:
        again = reader.measure(seen.others, rng.random(count, np.float32), rng.standard_normal(count, np.float32))
        beams, measured, codes, ids = _interleaved(sweep, (beams, measured, codes, ids), again)
    if moving is not None and config.motion == "deskewed":
        points = _in_frame(_along(origins, directions, beams, measured), T_world_lidar)
    else:
        points = _in_lidar(_along(sweep.origins, sweep.directions, beams, measured), T_lidar_head)
    return LidarScan(
        points=np.ascontiguousarray(points),
        intensity=codes,
        instance_ids=ids,
        ring=sweep.ring[beams],
        time=sweep.time[beams],
    )


_Readings = tuple[Int[np.ndarray, " m"], Float32[np.ndarray, " m"], Float32[np.ndarray, " m"], Int32[np.ndarray, " m"]]
"""Beams, distances (m), intensities and instance ids."""


@dataclass(frozen=True, eq=False)
class _Reader:
    """The receiver of one sweep."""

    config: LidarConfig
    sweep: Sweep
    hits: RayHits
    origins: Float32[np.ndarray, "n 3"]
    directions: Float32[np.ndarray, "n 3"]
    rng: np.random.Generator
    unit: LidarUnit | None
    finishes: Finishes | None

    def measure(
        self, echoes: Echoes, chance: Float32[np.ndarray, " n"], normal: Float32[np.ndarray, " n"]
    ) -> _Readings:
        """Return what is detected and how it is measured, in the order in which it was fired."""
        config, order = self.config, self.sweep.firing_order
        # Only what came back is worked on.
        beams = order[np.isfinite(echoes.distance)[order]]
        distance, reflectance = echoes.distance[beams], echoes.reflectance[beams]
        if self.finishes is not None:
            reflectance = reflectance * self._variation(self.finishes, echoes, beams, distance)
        power = relative_power(reflectance, distance, config)
        error = normal[beams] * range_sigma(power, config)
        ring = self.sweep.ring[beams]
        if self.unit is not None:
            error += self.unit.bias[ring]
        measured = quantised(distance + error, config.range_step)
        kept = (measured >= config.min_range) & (measured <= config.max_range)
        kept &= detected(power, chance[beams], config)
        sensed = reflectance[kept] * intensity_factor(distance[kept], ring[kept], config, self.unit, self.rng)
        return beams[kept], measured[kept], intensity(sensed, config), echoes.instance_ids[beams[kept]]

    def _variation(
        self, finishes: Finishes, echoes: Echoes, beams: Int[np.ndarray, " m"], distance: Float32[np.ndarray, " m"]
    ) -> Float32[np.ndarray, " m"]:
        """Return how the surfaces that sent echoes differ from their materials."""
        materials = self.hits.materials[beams]
        factor = finishes.variation(materials, echoes.instance_ids[beams])
        if finishes.grain is None:
            return factor
        points = _along(self.origins, self.directions, beams, distance)
        return factor * finishes.grain_at(materials, points, columns(self.hits.normals, beams))


def _turned(config: LidarConfig, rng: np.random.Generator) -> Transform | None:
    """Return by what the azimuths of a sweep are beside those of the table; None = not at all."""
    if config.azimuth_phase == "fixed":
        return None
    return make_transform(rotation_z(np.deg2rad(config.azimuth_step_deg) * float(rng.uniform(-0.5, 0.5))))


def _interleaved(sweep: Sweep, first: _Readings, second: _Readings) -> _Readings:
    """Return the readings of both, each second one behind the first of its pulse."""
    place = np.empty(len(sweep.firing_order), np.intp)
    place[sweep.firing_order] = np.arange(len(place))
    order = np.argsort(place[np.concatenate([first[0], second[0]])], kind="stable")
    beams, measured, codes, ids = (np.concatenate(pair)[order] for pair in zip(first, second, strict=True))
    return beams, measured, codes, ids


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
    return motion.carried(origins, directions, since)


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
    return points.T


def _in_lidar(points: Float32[np.ndarray, "n 3"], T_lidar_head: Transform | None) -> Float32[np.ndarray, "n 3"]:
    """Return points of the head's frame in the LiDAR's, which differs by a small turn about z."""
    if T_lidar_head is None:
        return points
    cosine, sine = np.float32(T_lidar_head[0, 0]), np.float32(T_lidar_head[1, 0])
    x, y, z = points.T
    return np.stack([cosine * x - sine * y, sine * x + cosine * y, z]).T


def _in_frame(points: Float32[np.ndarray, "n 3"], T_world_lidar: Transform) -> Float32[np.ndarray, "n 3"]:
    """Return world points in the LiDAR frame."""
    rotation, position = T_world_lidar[:3, :3].astype(np.float32), T_world_lidar[:3, 3].astype(np.float32)
    return np.einsum("ni,ij->nj", points - position, rotation)
