"""Beams with a width: at edges, several surfaces share a pulse."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int

from warehouse_sim.render.raycaster import RayCaster, RayHits
from warehouse_sim.sensors.film import FilmSight
from warehouse_sim.sensors.lidar.config import LidarConfig
from warehouse_sim.sensors.lidar.echo import Echoes, PulseEchoes, Which, film_met, thin_echoes, with_film
from warehouse_sim.sensors.lidar.finishes import Finishes
from warehouse_sim.sensors.lidar.sweep import Sweep, columns

_PROBE_AT = 0.571
"""Centroid of the outer thirds of a round beam, in half angles: (4 / pi) (1 - t^2)^1.5 with t = 0.265."""
_SMALLEST_STEP = 0.05
"""Surfaces nearer to one another than this need no closer look (m): blended, they lie within the noise."""


_FIRST: dict[str, Which] = {"strongest": "strongest", "last": "last", "dual": "strongest"}


@dataclass(frozen=True, eq=False)
class SeenSweep:
    """What came back of a sweep's pulses."""

    echoes: Echoes
    """The first that is reported of each beam."""
    others: Echoes | None
    """The second one, with dual return."""
    hits: RayHits
    """What the beams' axes meet."""
    rays: int
    """How many it took."""


def see_sweep(
    raycaster: RayCaster,
    config: LidarConfig,
    sweep: Sweep,
    origins: Float32[np.ndarray, "n 3"],
    directions: Float32[np.ndarray, "n 3"],
    finishes: Finishes | None = None,
    film: FilmSight | None = None,
) -> SeenSweep:
    """Return the echoes of the sweep's beams.

    One ray follows each beam's axis. Where a neighbour on the grid meets another surface at another distance, one more
    ray looks at the outer third of the beam on that side and stands for a third of its light. What is narrower than
    the gap between beams and met by no axis is missed.

    Args:
        raycaster: The scene.
        config: Divergence, pulse length and extinction.
        sweep: The grid that the beams form.
        origins: Where they start in the world (m).
        directions: Unit vectors in the world.
        finishes: Gloss of the materials; None = all are matt.
        film: Of the scene; what the axis meets is before all of the beam. None = there is none.
    """
    hits = raycaster.cast(origins, directions, coherent=True)
    echoes = thin_echoes(hits, directions, finishes)
    if config.returns == "dual":
        nothing = np.full(len(directions), np.inf, np.float32), np.zeros(len(directions), np.float32)
        others = Echoes(*nothing, np.zeros(len(directions), np.int32))
    else:
        others = None
    met = None if film is None else film_met(film, sweep.shape, origins, directions, hits)
    thin = not any(config.divergence_mrad)
    if thin and met is None:
        return SeenSweep(echoes, others, hits, len(directions))
    echoes = Echoes(echoes.distance.copy(), echoes.reflectance, echoes.instance_ids.copy())
    beams, sides = (np.empty(0, np.intp),) * 2 if thin else _edges(hits, sweep)
    rays = _probes(columns(directions, beams), sides, config.divergence_mrad)
    probes = thin_echoes(raycaster.cast(columns(origins, beams), rays, coherent=True), rays, finishes)
    mixed, fractions = _fractions(echoes, probes, beams, sides)
    if met is not None:
        mixed, fractions = with_film(mixed, fractions, echoes, met)
    pulses = PulseEchoes.of(fractions, pulse_length=config.pulse_length, extinction=config.extinction)
    _put(echoes, mixed, pulses.pick(_FIRST[config.returns]))
    if others is not None:
        _put(others, mixed, pulses.pick("other"))
    return SeenSweep(echoes, others, hits, len(directions) + len(rays))


def _put(echoes: Echoes, beams: Int[np.ndarray, " m"], found: Echoes) -> None:
    echoes.distance[beams], echoes.reflectance[beams] = found.distance, found.reflectance
    echoes.instance_ids[beams] = found.instance_ids


def _edges(hits: RayHits, sweep: Sweep) -> tuple[Int[np.ndarray, " m"], Int[np.ndarray, " m"]]:
    """Return which beams have an edge beside them, in order, and on which side: left 0, right 1, up 2, down 3."""
    distance = hits.distance.reshape(sweep.shape)
    piece, owner = hits.pieces.reshape(sweep.shape), hits.instance_ids.reshape(sweep.shape)
    found = []
    number = np.arange(distance.size).reshape(sweep.shape)
    every, but_first, but_last = slice(None), slice(1, None), slice(-1)
    pairs = [(0, every, but_last, 1, every, but_first), (3, but_last, every, 2, but_first, every)]
    if sweep.closed:
        pairs.append((0, every, slice(-1, None), 1, every, slice(1)))
    for side_of_a, ring_a, column_a, side_of_b, ring_b, column_b in pairs:
        a, b = (ring_a, column_a), (ring_b, column_b)
        with np.errstate(invalid="ignore"):  # both infinite: no step
            edge = np.abs(distance[a] - distance[b]) > _SMALLEST_STEP
        edge &= (piece[a] != piece[b]) | (owner[a] != owner[b])
        found += [(side_of_a, number[a][edge]), (side_of_b, number[b][edge])]
    beams = np.concatenate([beams for _, beams in found])
    sides = np.repeat([side for side, _ in found], [len(beams) for _, beams in found])
    order = np.argsort(beams, kind="stable")  # neighbours meet much the same, which makes casting faster
    return beams[order], sides[order]


def _probes(
    axes: Float32[np.ndarray, "m 3"], sides: Int[np.ndarray, " m"], divergence_mrad: tuple[float, float]
) -> Float32[np.ndarray, "m 3"]:
    """Return the directions of rays through the outer third of beams, on the given side of each.

    To the left of a direction (x, y, z) that is not vertical is the level unit vector (-y, x, 0) / l, above it
    (-x z, -y z, l^2) / l, with l^2 = x^2 + y^2.

    Args:
        axes: Unit vectors along the beams.
        sides: Left 0, right 1, up 2, down 3.
        divergence_mrad: Full widths of the beam, level and upright.
    """
    half = np.asarray(divergence_mrad, np.float32) * np.float32(0.5e-3 * _PROBE_AT)
    leftward, upward = np.array([[half[0], -half[0], 0, 0], [0, 0, half[1], -half[1]]], np.float32)[:, sides]
    x, y, z = axes.T
    level = np.sqrt(x * x + y * y)
    rays = np.empty((3, len(sides)), np.float32)
    np.add(z, upward * level, out=rays[2])
    leftward /= level
    upward *= z / level
    rays[0] = x - leftward * y - upward * x
    rays[1] = y + leftward * x - upward * y
    return rays.T


def _fractions(
    axis: Echoes, probes: Echoes, beams: Int[np.ndarray, " m"], sides: Int[np.ndarray, " m"]
) -> tuple[Int[np.ndarray, " k"], Echoes]:
    """Return the beams in which a probe meets another distance than the axis, and what their fractions meet."""
    with np.errstate(invalid="ignore"):
        differs = np.abs(probes.distance - axis.distance[beams]) > _SMALLEST_STEP
    is_mixed = np.zeros(len(axis.distance), bool)
    is_mixed[beams[differs]] = True
    mixed = np.flatnonzero(is_mixed)
    chosen = np.flatnonzero(is_mixed[beams])
    row, column = np.searchsorted(mixed, beams[chosen]), 1 + sides[chosen]
    shape = (len(mixed), 5)
    fractions = Echoes(np.full(shape, np.inf, np.float32), np.zeros(shape, np.float32), np.zeros(shape, np.int32))
    probed = np.bincount(row, minlength=len(mixed))[:, None]
    part = np.float32(1.0) / np.maximum(probed + 1, 3).astype(np.float32)
    for whole, central, others in (
        (fractions.distance, axis.distance, probes.distance),
        (fractions.reflectance, axis.reflectance, probes.reflectance),
        (fractions.instance_ids, axis.instance_ids, probes.instance_ids),
    ):
        whole[:, 0], whole[row, column] = central[mixed], others[chosen]
    fractions.reflectance[:, 1:] *= part
    fractions.reflectance[:, :1] *= 1 - probed * part
    return mixed, fractions
