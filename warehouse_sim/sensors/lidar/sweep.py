"""All rays of a turn on a grid of rings and azimuths, made once for each configuration."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float32, Int, Int32

from warehouse_sim.sensors.lidar.config import LidarConfig
from warehouse_sim.sensors.lidar.lasers import LASERS


@dataclass(frozen=True, eq=False)
class Sweep:
    """Rays on a grid, ring by ring from the topmost down; columns look alike in azimuth, not in time."""

    shape: tuple[int, int]
    """Rings and azimuths."""
    closed: bool
    """Whether the last azimuth is a neighbour of the first."""
    origins: Float32[np.ndarray, "n 3"]
    """Where rays start in the LiDAR frame (m)."""
    directions: Float32[np.ndarray, "n 3"]
    """Unit vectors in the LiDAR frame."""
    time: Float32[np.ndarray, " n"]
    """Since the sweep began (s)."""
    forward_time: float
    """When the head points forward, or comes nearest to it (s)."""
    ring: Int32[np.ndarray, " n"]
    firing_order: Int[np.ndarray, " n"]
    """Which ray fires first, second, ..."""


@lru_cache(maxsize=8)
def make_sweep(config: LidarConfig) -> Sweep:
    """Return the rays of one turn.

    A laser that looks to the left of the head gets to an azimuth earlier than one that looks to its right; in a column
    of the grid, rays stand at most half a step beside one another. Rays start where the calibration of Velodyne's
    drivers puts them: offset perpendicular to the ray, upwards and to the left; an Ouster's, ahead of the axis.
    """
    lasers = LASERS[config.model]()
    top_down = np.argsort(lasers.rings())[:: config.every_nth_beam]
    step = np.deg2rad(config.azimuth_step_deg)
    first, last = np.deg2rad(config.azimuth_range_deg)
    closed = bool(last - first > 2.0 * np.pi - step / 2.0)
    # A full turn must not fire twice in the direction where it closes; any other one includes both ends.
    count = round((last - first) / step) if closed else int((last - first) / step + 1e-6) + 1
    aside, up, left, delay = (item[top_down, None] for item in (lasers.azimuth, lasers.up, lasers.left, lasers.delay))
    clockwise = config.spin == "clockwise"
    if lasers.turns_between:
        aside = aside + delay * (2.0 * np.pi * config.turns_per_second * (-1.0 if clockwise else 1.0))
    lead = np.round(aside / step).astype(int)
    column = np.arange(count)
    cycle, forward = _cycles(column - lead, -first / step, clockwise)
    if closed:
        cycle, forward = cycle % count, forward % count
    else:
        cycle, forward = cycle - cycle.min(), forward - cycle.min()
    period = step / (2.0 * np.pi * config.turns_per_second)
    azimuth = first + column * step + (aside - lead * step)
    elevation = np.broadcast_to(lasers.elevation[top_down, None], azimuth.shape)
    return Sweep(
        shape=azimuth.shape,
        closed=closed,
        origins=_vectors(*_origins(azimuth, elevation, up, left, lasers.ahead, azimuth - aside)),
        directions=_vectors(
            np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
        ),
        time=_fixed(cycle * period + delay, np.float32),
        forward_time=float(np.clip(forward, 0, cycle.max()) * period),
        ring=_fixed(np.broadcast_to(np.arange(len(top_down))[:, None], azimuth.shape), np.int32),
        firing_order=_fixed(np.lexsort((np.repeat(top_down, count), cycle.ravel())), np.intp),
    )


def columns(vectors: Float32[np.ndarray, "n 3"], chosen: Int[np.ndarray, " m"]) -> Float32[np.ndarray, "m 3"]:
    """Return some of the vectors, which are stored component by component, in the same way."""
    return np.take(vectors.T, chosen, axis=1).T


def _cycles(head: Int[np.ndarray, "k n"], forward: float, clockwise: bool) -> tuple[Int[np.ndarray, "k n"], float]:
    """Return in which firing cycle, counted from any, the head is at each step of azimuth, and when it looks forward.

    Args:
        head: Where the head points (steps from the first azimuth, counter-clockwise).
        forward: Of the azimuth 0, in the same steps.
        clockwise: Which way it turns, seen from above.
    """
    return (-head, -forward) if clockwise else (head, forward)


def _origins(
    azimuth: np.ndarray, elevation: np.ndarray, up: np.ndarray, left: np.ndarray, ahead: float, head: np.ndarray
) -> tuple[np.ndarray, ...]:
    radial = -up * np.sin(elevation)
    x = radial * np.cos(azimuth) - left * np.sin(azimuth) + ahead * np.cos(head)
    y = radial * np.sin(azimuth) + left * np.cos(azimuth) + ahead * np.sin(head)
    return x, y, up * np.cos(elevation)


def _vectors(*components: np.ndarray) -> Float32[np.ndarray, "n 3"]:
    """Return vectors whose components lie one after the other in memory, as whole columns are worked on."""
    return _fixed(np.stack([item.ravel() for item in components]), np.float32).reshape(3, -1).T


def _fixed(values: np.ndarray, dtype: type) -> np.ndarray:
    """Return a flat copy that nobody can change, as it is shared."""
    flat: np.ndarray = np.array(values, dtype).ravel()
    flat.setflags(write=False)
    return flat
