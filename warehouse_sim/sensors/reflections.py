"""Light of an emitter beside the lens that comes back by smooth surfaces or retroreflectors."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.render.raycaster import RayCaster, RayHits
from warehouse_sim.schema.things import RETROREFLECTIVE

_ANGLES_DEG = (0.2, 1.0 / 3.0, 1.0, 10.0)
_OVER_WHITE = tuple(np.pi * value for value in (330.0, 250.0, 25.0, 0.25))
_CENTRED_DEG = 0.01


def returned_by_retroreflectors(
    remission: Float32[np.ndarray, "h w"],
    cosine: Float32[np.ndarray, "h w"],
    depth: Float32[np.ndarray, "h w"],
    offset: float,
) -> Float32[np.ndarray, "h w"] | None:
    """Return the light that comes back from retroreflectors, white plaster facing the lamp at the same place = 1.

    Args:
        remission: Of the material at each pixel; 0 is returned where it is less than ``RETROREFLECTIVE``.
        cosine: Of the angle of incidence, 0-1.
        depth: Of the pixels (m).
        offset: From the lamp to the lens (m).

    Returns:
        None where no pixel shows a retroreflector, so that what follows can be left out.
    """
    back = (remission >= np.float32(RETROREFLECTIVE)) & (depth > 0)
    if not back.any():
        return None
    light = np.zeros_like(depth)
    angle = np.maximum(np.degrees(np.arctan2(offset, depth[back].astype(float))), _CENTRED_DEG)
    fractions = np.exp(np.interp(np.log(angle), np.log(_ANGLES_DEG), np.log(_OVER_WHITE)))
    light[back] = fractions * cosine[back].astype(float) ** 6
    return light


Image = Float32[np.ndarray, "h w"]
_LEAST = 0.02
"""Fraction of light thrown on below which a surface is not followed: matt ones seen straight on."""
_SMOOTH = 0.35
"""Perceptual roughness at which 1/e of the Fresnel reflection still goes the mirror's way; no source: a prior."""
_OFF = 1e-3
"""From a surface to where the ray that leaves it starts (m)."""


@dataclass(frozen=True, eq=False)
class Reflected:
    """The light that reaches the pixels by way of one smooth surface."""

    light: Image
    """Relative to white plaster that faces the emitter from 1 m; 0 = none."""
    ranges: Image
    """Half the length of its way there and back (m); 0 where there is none."""
    kept: Image
    """Fraction of its diffuse light that a surface still sends back, as what it throws on never enters it."""


def reflected_light(
    hits: RayHits,
    origin: Float[np.ndarray, " 3"],
    directions: Float[np.ndarray, "n 3"],
    materials: Float32[np.ndarray, "m 3"],
    caster: RayCaster,
) -> Float32[np.ndarray, "n 3"]:
    """Return light, range and what is kept for rays that met a first surface; see ``Reflected``.

    The way there is either direct or over the surface, the way back over it; both arrive in one pixel. Fresnel's share
    is Schlick's, ``F0 + (1 - F0) (1 - cos)^5``. Whether something stands in the direct way is not asked.

    Args:
        hits: First surfaces on the rays.
        origin: Of all rays (m, world).
        directions: Of the rays (world), of any length.
        materials: Remission, roughness and metallic by ``RayHits.materials``; a last row of zeros for -1.
        caster: Rays in the same scene.
    """
    length = np.linalg.norm(directions, axis=1)
    away = (directions / length[:, None]).astype(np.float32)
    cosine = np.clip(-np.einsum("ni,ni->n", away, hits.normals), 0.0, 1.0)
    remission, roughness, metallic = materials[hits.materials].T
    straight = np.float32(0.04) + np.float32(0.96) * metallic * np.minimum(remission, np.float32(1.0))
    thrown = straight + (np.float32(1.0) - straight) * (np.float32(1.0) - cosine) ** 5
    thrown = thrown * np.exp(-((roughness / np.float32(_SMOOTH)) ** 4))
    result = np.zeros((len(away), 3), np.float32)
    # Light crosses the surface on its way in and on its way out.
    result[:, 2] = (np.float32(1.0) - thrown) ** 2
    taken = np.flatnonzero((thrown > _LEAST) & (cosine > 0))
    if len(taken) == 0:
        return result
    to, normal = away[taken], hits.normals[taken]
    onward = to + np.float32(2.0) * cosine[taken, None].astype(np.float32) * normal
    first = (hits.distance * length)[taken]
    at = origin + first[:, None] * to + _OFF * normal
    second = caster.cast(at, onward)
    found = np.isfinite(second.distance)
    there = at[found] + second.distance[found, None] * onward[found]
    whole = first[found] + second.distance[found]
    back = origin - there
    direct = np.linalg.norm(back, axis=1)
    fraction, rho = thrown[taken][found], second.remission[found]
    over = fraction * np.abs(np.einsum("ni,ni->n", onward[found], second.normals[found])) / whole**2
    straight_there = np.clip(np.einsum("ni,ni->n", back, second.normals[found]) / direct, 0.0, None) / direct**2
    both = over + straight_there
    result[taken[found], 0] = fraction * rho * both
    result[taken[found], 1] = (over * whole + straight_there * (whole + direct) / 2) / np.maximum(both, 1e-9)
    return result
