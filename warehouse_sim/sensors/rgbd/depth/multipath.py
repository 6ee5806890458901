"""Light that reaches a point by way of other surfaces, and so seems to come from farther away."""

import cv2
import numpy as np
from jaxtyping import Float32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.sensors.pixel_rays import pixel_stretch
from warehouse_sim.sensors.surfaces import camera_rays

_STRIDE = 4
"""Pixels from one sample to the next."""
_RINGS = ((2, 1.0, 3.5), (5, 3.5, 7.5), (10, 7.5, 14.0), (20, 14.0, 28.0))
"""Radius at which the surroundings are looked at, and the radii between which it stands for them (samples)."""
_WAYS = tuple((np.cos(a), np.sin(a)) for a in np.deg2rad(np.arange(0, 360, 45)))

Image = Float32[np.ndarray, "h w"]


def multipath_bias(
    depth: Image, normals: Float32[np.ndarray, "h w 3"], remission: Image, camera: PinholeCamera
) -> Image:
    """Return by how much the range grows (m) through light that bounced once off what the image itself shows.

    An emitter beside the lens lights a patch j, which sends light on to point i. Against direct light at i its power is
    w = rho_j E_j F_ij / E_i with E = cos / r^2 and the form factor F of Lambertian patches, and its path is longer by
    (r_j + |x_i - x_j| - r_i) / 2. The range grows by the mean of those lengths, weighted with w against 1 for the
    direct light: the limit of small phase differences of the model in Fuchs 2010, "Multipath interference compensation
    in time-of-flight camera images". Patches outside of the image and further bounces are left out.

    Args:
        depth: True z-depth (m).
        normals: Unit normals in the camera frame.
        remission: Diffuse reflectance.
        camera: Intrinsics.
    """
    pick = (slice(None, None, _STRIDE), slice(None, None, _STRIDE))
    rays, z = camera_rays(camera)[pick], depth[pick]
    points, n, rho = rays * z[..., None], normals[pick], remission[pick]
    length = np.sqrt(np.einsum("hwc,hwc->hw", rays, rays))
    r = z * length
    cosine = np.maximum(np.abs(np.einsum("hwc,hwc->hw", n, rays)) / length, np.float32(0.1))
    lit = np.divide(cosine, r * r, out=np.zeros_like(r), where=r > 0)
    area = np.float32(_STRIDE**2 / (camera.fx * camera.fy)) * z * z / (length * cosine)
    if camera.distortion is not None:
        area /= np.linalg.det(pixel_stretch(camera)[pick])
    patch = np.concatenate([points, n, np.stack([r, rho * lit, area], axis=-1)], axis=-1)
    total, weighted = np.zeros_like(r), np.zeros_like(r)
    for radius, inner, outer in _RINGS:
        share = np.float32(np.pi * (outer**2 - inner**2) / len(_WAYS))
        for x, y in _WAYS:
            other = _shifted(patch, round(radius * x), round(radius * y))
            power, longer = _by_way_of(other, points, n, r, share)
            total += power
            weighted += power * longer
    direct = total + lit
    bias = np.divide(weighted, direct, out=np.zeros_like(r), where=direct > 0)
    return cv2.resize(bias, depth.shape[::-1], interpolation=cv2.INTER_LINEAR)


def _by_way_of(
    other: Float32[np.ndarray, "h w 9"],
    points: Float32[np.ndarray, "h w 3"],
    normals: Float32[np.ndarray, "h w 3"],
    r: Image,
    share: np.float32,
) -> tuple[Image, Image]:
    """Return the light that points get by way of patches, and how much longer its way is (m)."""
    way = other[..., :3] - points
    squared = np.maximum(np.einsum("hwc,hwc->hw", way, way), np.float32(1e-6))
    at_point = np.maximum(np.einsum("hwc,hwc->hw", way, normals), np.float32(0.0))
    at_patch = np.maximum(-np.einsum("hwc,hwc->hw", way, other[..., 3:6]), np.float32(0.0))
    area = share * other[..., 8]
    factor = at_point * at_patch / squared * area / (np.float32(np.pi) * squared + area)
    longer = np.float32(0.5) * (other[..., 6] + np.sqrt(squared) - r)
    return other[..., 7] * factor, np.maximum(longer, np.float32(0.0))


def _shifted(patch: Float32[np.ndarray, "h w 9"], x: int, y: int) -> Float32[np.ndarray, "h w 9"]:
    """Return for each sample the one ``x`` to the right and ``y`` below; at the border those of the border."""
    height, width = patch.shape[:2]
    rows = np.clip(np.arange(height) + y, 0, height - 1)
    columns = np.clip(np.arange(width) + x, 0, width - 1)
    return patch[rows][:, columns]
