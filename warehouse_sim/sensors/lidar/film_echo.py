"""Pulses through stretch film: an echo of the film, and what it lets pass there and back of all others."""

import numpy as np
from jaxtyping import Float32, Int

from warehouse_sim.render.raycaster import RayHits
from warehouse_sim.sensors.film import FilmMet, FilmSight
from warehouse_sim.sensors.film.blocks import Cones, blocks_of
from warehouse_sim.sensors.lidar.echo import Echoes
from warehouse_sim.sensors.lidar.sweep import columns

_BRIGHTEST = np.float32(10.0)
"""Where a receiver is taken to saturate: 1000 %, as for other highlights."""


def film_met(
    film: FilmSight,
    shape: tuple[int, int],
    origins: Float32[np.ndarray, "n 3"],
    directions: Float32[np.ndarray, "n 3"],
    hits: RayHits,
) -> FilmMet | None:
    """Return the film that the axes of a sweep's beams meet; None where there is none.

    Args:
        film: Of the scene.
        shape: Rings and azimuths of the sweep.
        origins: Where beams start in the world (m).
        directions: Unit vectors in the world.
        hits: What is solid on them.
    """
    blocks = blocks_of(shape)
    middle = columns(directions, blocks.middle)
    corners = np.array([columns(directions, corner) for corner in blocks.corners])
    beams = blocks.rays(film.near(columns(origins, blocks.middle), Cones.around(middle, corners)))
    return film.met(beams, columns(origins, beams), columns(directions, beams), hits.distance[beams])


def with_film(
    mixed: Int[np.ndarray, " k"], fractions: Echoes, axis: Echoes, film: FilmMet
) -> tuple[Int[np.ndarray, " n"], Echoes]:
    """Return the beams that meet more than one surface, film included, and their fractions.

    A point on film bears the id of the film itself, which is an object of its own. What the film turns aside still
    lights what is close behind it, so that it counts as passed.

    Args:
        mixed: Beams that meet several solid surfaces, rising.
        fractions: What those meet, by rows.
        axis: What the axis of each beam meets.
        film: Before some beams.
    """
    beams = np.union1d(mixed, film.rays)
    width = fractions.distance.shape[1] + 1
    whole = Echoes(
        np.full((len(beams), width), np.inf, np.float32),
        np.zeros((len(beams), width), np.float32),
        np.zeros((len(beams), width), np.int32),
    )
    rows, filmed = np.searchsorted(beams, mixed), np.searchsorted(beams, film.rays)
    for to, of_axis, of_fractions, of_film in (
        (whole.distance, axis.distance, fractions.distance, film.distance),
        (whole.instance_ids, axis.instance_ids, fractions.instance_ids, film.instance_ids),
        (
            whole.reflectance,
            axis.reflectance,
            fractions.reflectance,
            np.minimum(film.diffuse + film.glossy, _BRIGHTEST),
        ),
    ):
        to[:, 0] = of_axis[beams]
        to[rows, :-1] = of_fractions
        if to is whole.reflectance:
            to[filmed] *= np.square(film.passed)[:, None]
        to[filmed, -1] = of_film
    return beams, whole
