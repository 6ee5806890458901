"""Active illumination: the material behind each pixel, and the light it sends back to an emitter beside the lens."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import SceneSpec
from warehouse_sim.sensors.pixel_rays import pixel_tangents
from warehouse_sim.sensors.reflections import Reflected, reflected_light

Image = Float32[np.ndarray, "h w"]
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
