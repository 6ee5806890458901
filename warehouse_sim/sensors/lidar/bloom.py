"""Blooming: so much light comes from a retroreflector that beams beside it see it, too.

A beam's light has skirts, and optics scatter. What a beam at an angle theta to a retroreflector gets of it falls from
1000 % of remission by a factor of ten for each half of ``bloom_deg``; no source, a prior of that shape.
"""

import numpy as np
from jaxtyping import Int

from warehouse_sim.render.raycaster import RayHits
from warehouse_sim.schema.things import RETROREFLECTIVE
from warehouse_sim.sensors.lidar.config import LidarConfig
from warehouse_sim.sensors.lidar.echo import Echoes
from warehouse_sim.sensors.lidar.sweep import Sweep, columns

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
