"""What comes back of a pulse: the echo of one surface, or the strongest of several."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int32

from warehouse_sim.render.raycaster import RayHits

_RETROREFLECTIVE = 2.0
"""Remission from which light goes back to where it came from, whatever the incidence."""


@dataclass(frozen=True, eq=False)
class Echoes:
    """One echo of each beam, or of each share of a beam."""

    distance: Float32[np.ndarray, "*shape"]
    """m; infinite when nothing comes back."""
    reflectance: Float32[np.ndarray, "*shape"]
    """Remission times cosine of incidence of a surface that would fill the beam and return as much."""
    instance_ids: Int32[np.ndarray, "*shape"]


def thin_echoes(hits: RayHits, directions: Float32[np.ndarray, "n 3"]) -> Echoes:
    """Return the echoes of infinitely thin beams along unit ``directions`` (world)."""
    x, y, z = (hits.normals[:, i] * directions[:, i] for i in range(3))  # columns, as the arrays lie in memory
    cosine = np.abs(x + y + z)
    reflectance = np.where(hits.remission >= _RETROREFLECTIVE, hits.remission, hits.remission * cosine)
    return Echoes(hits.distance, reflectance, hits.instance_ids)


def strongest_echoes(shares: Echoes, *, pulse_length: float, extinction: float) -> Echoes:
    """Return the strongest echo of each pulse, with the instance of its strongest share.

    Surfaces less than a pulse length apart along the ray blend into one echo at their power-weighted mean distance: a
    mixed pixel, which lies where nothing is. Surfaces farther apart give echoes of their own.

    Args:
        shares: Rows of the shares of one pulse, each with the reflectance of its part; infinite distance = none.
        pulse_length: m along the ray.
        extinction: Coefficient a of ``exp(-2 a R) / R^2`` (1/m).
    """
    order = np.argsort(shares.distance, axis=1, kind="stable")
    distance, reflectance, ids = (
        np.take_along_axis(item, order, axis=1) for item in (shares.distance, shares.reflectance, shares.instance_ids)
    )
    met = np.isfinite(distance)
    near = np.where(met, distance, np.float32(1.0))
    power = np.where(met, reflectance * np.exp(np.float32(-2.0 * extinction) * near) / (near * near), np.float32(0.0))
    with np.errstate(invalid="ignore"):  # both infinite: one echo, of nothing
        apart = np.diff(distance, axis=1) > pulse_length
    count, width = distance.shape
    echo = np.concatenate([np.zeros((count, 1), np.intp), np.cumsum(apart, axis=1)], axis=1)
    slot = (echo + width * np.arange(count)[:, None]).ravel()
    total = np.bincount(slot, power.ravel(), width * count).reshape(count, width)
    moment = np.bincount(slot, (power * near).ravel(), width * count).reshape(count, width)
    rows, best = np.arange(count), total.argmax(axis=1)
    strength = total[rows, best]
    found = strength > 0
    mean = np.divide(moment[rows, best], strength, out=np.ones(count), where=found)
    own = np.where(echo == best[:, None], power, np.float32(-1.0)).argmax(axis=1)
    return Echoes(
        np.where(found, mean, np.inf).astype(np.float32),
        (strength * mean**2 * np.exp(2.0 * extinction * mean)).astype(np.float32),
        np.where(found, ids[rows, own], 0).astype(np.int32),
    )
