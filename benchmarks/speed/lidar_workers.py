"""Sweeps by two worker processes side by side, as generating datasets runs them: rays a second on the wall."""

import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.synchronize import Barrier
from typing import Any

import numpy as np

from warehouse_sim.dataset.formats.kitti.writer import beam_bytes, point_bytes
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.processes import prepare_worker
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import SceneSpec
from warehouse_sim.sensors.lidar import LidarConfig, scan
from warehouse_sim.sensors.lidar.finishes import finishes_of
from warehouse_sim.sensors.lidar.receiver import LidarUnit

WORKERS = 2
ROUNDS = 8


@dataclass(frozen=True)
class _Worked:
    """What one process did."""

    start: float
    """On the clock of all processes (s)."""
    end: float
    cpu_s: float


def sweep_to_bytes(
    scene: SceneSpec,
    raycaster: RayCaster,
    config: LidarConfig,
    T_world_lidar: Transform,
    rng: np.random.Generator,
) -> int:
    """Make a sweep and all that is written of it: points with intensity, instance ids, rings and times; in bytes.

    The unit and the surfaces are drawn again for each sweep, as the sensor does it.
    """
    unit = LidarUnit.sample(config, np.random.default_rng(1))
    finishes = finishes_of(scene, raycaster.materials, config.brightness, np.random.default_rng(2))
    found = scan(raycaster, config, T_world_lidar, rng, unit=unit, finishes=finishes)
    return len(point_bytes(found)) + len(found.instance_ids.astype("<i4").tobytes()) + len(beam_bytes(found))


def side_by_side(
    scene: SceneSpec, config: LidarConfig, T_world_lidars: list[Transform], rays: float, beams: int, sweeps: int
) -> dict[str, Any]:
    """Return what two processes achieve together, in that of some rounds in which other work took least of the cores.

    Args:
        scene: What is swept.
        config: The LiDAR.
        T_world_lidars: Where from, in turns.
        rays: Rays of a sweep, in the mean over these places.
        beams: Beams of a sweep.
        sweeps: How many each process makes a round.
    """
    context = get_context("spawn")
    barrier = context.Barrier(WORKERS)
    with ProcessPoolExecutor(WORKERS, context, _begin, (barrier,)) as pool:
        jobs = [pool.submit(_sweep, scene, config, T_world_lidars, sweeps, number) for number in range(WORKERS)]
        rounds = list(zip(*(job.result() for job in jobs), strict=True))
    found = [_together(worked, rays, beams, WORKERS * sweeps) for worked in rounds]
    return max(found, key=lambda item: item["cores_held"]) | {"rounds": len(rounds)}


def _together(worked: Sequence[_Worked], rays: float, beams: int, sweeps: int) -> dict[str, Any]:
    """Return the rates of one round."""
    wall = max(item.end for item in worked) - min(item.start for item in worked)
    cpu = sum(item.cpu_s for item in worked)
    return {
        "sweeps": sweeps,
        "rays_per_wall_s": rays * sweeps / wall,
        "beams_per_wall_s": beams * sweeps / wall,
        "rays_per_cpu_s": rays * sweeps / cpu,
        "beams_per_cpu_s": beams * sweeps / cpu,
        # Below 1, other work took part of the two cores, or one process waited for the other.
        "cores_held": cpu / wall / WORKERS,
    }


def _begin(barrier: Barrier) -> None:
    global _barrier
    prepare_worker()
    _barrier = barrier


def _sweep(
    scene: SceneSpec, config: LidarConfig, T_world_lidars: list[Transform], sweeps: int, number: int
) -> list[_Worked]:
    raycaster, rng = RayCaster(scene), np.random.default_rng(number)
    for T_world_lidar in T_world_lidars[:2]:
        sweep_to_bytes(scene, raycaster, config, T_world_lidar, rng)
    worked = []
    for _ in range(ROUNDS):
        _barrier.wait()
        cpu, start = time.process_time(), time.monotonic()
        for turn in range(sweeps):
            sweep_to_bytes(scene, raycaster, config, T_world_lidars[turn % len(T_world_lidars)], rng)
        worked.append(_Worked(start, time.monotonic(), time.process_time() - cpu))
    return worked


_barrier: Barrier
