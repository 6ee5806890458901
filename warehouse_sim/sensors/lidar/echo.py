"""What comes back of a pulse: the echo of one surface, or those of several, stretch film among them.

A surface that stops only part of a pulse, such as film, is one more share: the columns of ``PulseEchoes.of`` are
whatever a pulse meets, each with the reflectance of the part of the light that reaches it and comes back.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float, Float32, Int, Int32

from warehouse_sim.render.raycaster import RayHits
from warehouse_sim.schema.things import RETROREFLECTIVE
from warehouse_sim.sensors.film import FilmMet, FilmSight
from warehouse_sim.sensors.film.blocks import Cones, blocks_of
from warehouse_sim.sensors.lidar.finishes import Finishes
from warehouse_sim.sensors.lidar.sweep import columns

Which = Literal["strongest", "last", "other"]


@dataclass(frozen=True, eq=False)
class Echoes:
    """One echo of each beam, or of each fraction of a beam."""

    distance: Float32[np.ndarray, "*shape"]
    """m; infinite when nothing comes back."""
    reflectance: Float32[np.ndarray, "*shape"]
    """Remission times cosine of incidence of a surface that would fill the beam and return as much."""
    instance_ids: Int32[np.ndarray, "*shape"]


def thin_echoes(hits: RayHits, directions: Float32[np.ndarray, "n 3"], finishes: Finishes | None = None) -> Echoes:
    """Return the echoes of infinitely thin beams along unit ``directions`` (world).

    Args:
        hits: What they meet.
        directions: Of the beams.
        finishes: Gloss of the materials; None = all are matt.
    """
    x, y, z = (hits.normals[:, i] * directions[:, i] for i in range(3))  # columns, as the arrays lie in memory
    cosine = np.abs(x + y + z)
    back = hits.remission >= RETROREFLECTIVE
    reflectance = np.where(back, hits.remission, hits.remission * cosine)
    if finishes is not None:
        glossy, shone = finishes.gloss(hits.remission, cosine, hits.materials)
        reflectance[glossy] = np.where(back[glossy], reflectance[glossy], shone)
    return Echoes(hits.distance, reflectance, hits.instance_ids)


@dataclass(frozen=True, eq=False)
class PulseEchoes:
    """All echoes of pulses that meet several surfaces, the nearest first.

    Surfaces less than a pulse length apart along the ray blend into one echo at their power-weighted mean distance: a
    mixed pixel, which lies where nothing is. Surfaces farther apart give echoes of their own.
    """

    fractions: Echoes
    """Of the pulses, by distance."""
    power: Float32[np.ndarray, "n k"]
    """Of each fraction."""
    echo: Int[np.ndarray, "n k"]
    """Which echo each fraction belongs to."""
    total: Float[np.ndarray, "n k"]
    """Power of each echo."""
    moment: Float[np.ndarray, "n k"]
    """Sum of power times distance of each echo."""
    extinction: float

    @classmethod
    def of(cls, fractions: Echoes, *, pulse_length: float, extinction: float) -> "PulseEchoes":
        """Sort the fractions of pulses into echoes.

        Args:
            fractions: Rows of the fractions of one pulse, each with the reflectance of its part; infinite distance =
                none.
            pulse_length: m along the ray.
            extinction: Coefficient a of ``exp(-2 a R) / R^2`` (1/m).
        """
        order = np.argsort(fractions.distance, axis=1, kind="stable")
        distance, reflectance, ids = (
            np.take_along_axis(item, order, axis=1)
            for item in (fractions.distance, fractions.reflectance, fractions.instance_ids)
        )
        met = np.isfinite(distance)
        near = np.where(met, distance, np.float32(1.0))
        falling = np.exp(np.float32(-2.0 * extinction) * near)
        power = np.where(met, reflectance * falling / (near * near), np.float32(0.0))
        with np.errstate(invalid="ignore"):  # both infinite: one echo, of nothing
            apart = np.diff(distance, axis=1) > pulse_length
        count, width = distance.shape
        echo = np.concatenate([np.zeros((count, 1), np.intp), np.cumsum(apart, axis=1)], axis=1)
        slot = (echo + width * np.arange(count)[:, None]).ravel()
        total = np.bincount(slot, power.ravel(), width * count).reshape(count, width)
        moment = np.bincount(slot, (power * near).ravel(), width * count).reshape(count, width)
        return cls(Echoes(distance, reflectance, ids), power, echo, total, moment, extinction)

    def pick(self, which: Which) -> Echoes:
        """Return one echo of each pulse, with the instance of its strongest share; none where there is no such.

        ``other`` is what dual return reports beside the strongest: the last, or the second strongest if the last is the
        strongest.
        """
        strongest, width = self.total.argmax(axis=1), self.total.shape[1]
        if which == "strongest":
            return self._echo(strongest)
        last = width - 1 - (self.total[:, ::-1] > 0).argmax(axis=1)
        if which == "last":
            return self._echo(last)
        rows = np.arange(len(strongest))
        rest = self.total.copy()
        rest[rows, strongest] = 0.0
        chosen = np.where(last == strongest, rest.argmax(axis=1), last)
        return self._echo(chosen, found=rest[rows, chosen] > 0)

    def _echo(self, chosen: Int[np.ndarray, " n"], found: np.ndarray | None = None) -> Echoes:
        rows = np.arange(len(chosen))
        strength = self.total[rows, chosen]
        found = strength > 0 if found is None else found
        mean = np.divide(self.moment[rows, chosen], strength, out=np.ones(len(chosen)), where=found)
        own = np.where(self.echo == chosen[:, None], self.power, np.float32(-1.0)).argmax(axis=1)
        whole = strength * mean**2 * np.exp(2.0 * self.extinction * mean)
        return Echoes(
            np.where(found, mean, np.inf).astype(np.float32),
            np.where(found, whole, 0.0).astype(np.float32),
            np.where(found, self.fractions.instance_ids[rows, own], 0).astype(np.int32),
        )


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
