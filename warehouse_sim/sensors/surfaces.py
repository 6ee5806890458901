"""Active illumination: the material behind each pixel, and the light it sends back to an emitter beside the lens."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raycaster import RayCaster, RayHits
from warehouse_sim.schema import SceneSpec
from warehouse_sim.schema.things import RETROREFLECTIVE
from warehouse_sim.sensors.pixel_rays import pixel_tangents

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


_STRIDE = 2
"""Pixels from one ray to the next: what is read of materials needs no finer ones, and rays cost time."""


@dataclass(frozen=True, eq=False)
class Surfaces:
    """What the materials of the pixels are like to near infrared; all zero where nothing is seen."""

    remission: Image
    """Diffuse reflectance relative to white plaster."""
    roughness: Image
    """Perceptual roughness, 0-1."""
    metallic: Image
    """0 for dielectrics, 1 for metals."""
    reflected: Reflected | None = None
    """Light by way of smooth surfaces, for sensors that require it."""


def see_surfaces(
    scene: SceneSpec,
    caster: RayCaster,
    camera: PinholeCamera,
    T_world_camera: Transform,
    reflections: bool = False,
) -> Surfaces:
    """Return the materials that a camera sees, by one ray for each two by two pixels through the first one's centre.

    Args:
        scene: Where the materials are defined.
        caster: Rays in the same scene.
        camera: Intrinsics.
        T_world_camera: Pose of the OpenCV camera.
        reflections: Whether to follow light by way of smooth surfaces, too.
    """
    rays = camera_rays(camera)[::_STRIDE, ::_STRIDE]
    in_world = np.einsum("nj,ij->ni", rays.reshape(-1, 3), T_world_camera[:3, :3].astype(np.float32))
    hits = caster.cast(np.broadcast_to(T_world_camera[:3, 3], in_world.shape), in_world, coherent=True)
    met = [scene.materials[name] for name in caster.materials]
    # One more row answers for rays that meet nothing, whose material is -1.
    table = np.array([*((item.remission, item.roughness, item.metallic) for item in met), (0, 0, 0)], np.float32)
    columns = [np.take(table, hits.materials, axis=0)]
    if reflections:
        columns.append(reflected_light(hits, T_world_camera[:3, 3], in_world, table, caster))
    sampled = np.concatenate(columns, axis=-1).reshape(*rays.shape[:2], -1)
    whole = sampled.repeat(_STRIDE, axis=0).repeat(_STRIDE, axis=1)[: camera.height, : camera.width]
    images = np.ascontiguousarray(np.moveaxis(whole, -1, 0))
    return Surfaces(images[0], images[1], images[2], Reflected(*images[3:]) if reflections else None)


def camera_rays(camera: PinholeCamera) -> Float32[np.ndarray, "h w 3"]:
    """Return for each pixel the point of its ray at z = 1 m in the camera frame."""
    rays = np.ones((camera.height, camera.width, 3), np.float32)
    rays[..., 0], rays[..., 1] = pixel_tangents(camera)
    return rays


def facing_cosine(normals: Float32[np.ndarray, "h w 3"], camera: PinholeCamera) -> Image:
    """Return the cosine between each pixel's surface normal and the way back to the camera; 0 on the background.

    Args:
        normals: Unit normals in the camera frame.
        camera: Intrinsics.
    """
    x, y = pixel_tangents(camera)
    along = normals[..., 0] * x + normals[..., 1] * y + normals[..., 2]
    return np.abs(along) / np.sqrt(np.float32(1.0) + x * x + y * y)


def returned_light(surfaces: Surfaces, cosine: Image) -> tuple[Image, Image]:
    """Return the diffuse and the glossy light that returns to an emitter beside the lens, white plaster facing it = 1.

    The glossy part is the GGX lobe of Walter et al. 2007 ("Microfacet models for refraction through rough surfaces")
    with the half vector along the view, pi D F0 G / (4 cos), where the masking G is taken to be the cosine.

    Args:
        surfaces: Materials.
        cosine: Of the angle of incidence, 0-1.
    """
    alpha2 = np.maximum(surfaces.roughness, np.float32(0.05)) ** 4
    lobe = alpha2 / np.square(cosine * cosine * (alpha2 - np.float32(1.0)) + np.float32(1.0))
    mirror = np.float32(0.04) + np.float32(0.96) * surfaces.metallic * np.minimum(surfaces.remission, np.float32(1.0))
    seen = surfaces.remission > 0
    diffuse = surfaces.remission * (np.float32(1.0) - surfaces.metallic) * cosine
    return diffuse, np.where(seen, np.float32(0.25) * mirror * lobe, np.float32(0.0))
