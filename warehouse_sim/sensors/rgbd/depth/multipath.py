"""Light that reaches a point by way of other surfaces, and so seems to come from farther away."""

import cv2
import numpy as np
from jaxtyping import Float32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.sensors.pixel_rays import pixel_stretch
from warehouse_sim.sensors.surfaces import camera_rays

_STRIDE = 8
"""Pixels from one sample to the next."""
_RINGS = ((1.5, 0.6, 2.5), (4, 2.5, 6.0), (9, 6.0, 13.0), (20, 13.0, 28.0))
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
    rays = np.ascontiguousarray(np.moveaxis(camera_rays(camera)[pick], -1, 0))
    z, n, rho = depth[pick], np.ascontiguousarray(np.moveaxis(normals[pick], -1, 0)), remission[pick]
    length = np.sqrt(_dot(rays, rays))
    points, r = rays * z, z * length
    cosine = np.maximum(np.abs(_dot(n, rays)) / length, np.float32(0.1))
    lit = np.divide(cosine, r * r, out=np.zeros_like(r), where=r > 0)
    area = np.float32(_STRIDE**2 / (camera.fx * camera.fy)) * z * z / (length * cosine)
    if camera.distortion is not None:
        area /= np.linalg.det(pixel_stretch(camera)[pick])
    reach = round(_RINGS[-1][0])
    patch = np.pad(
        np.concatenate([points, n, np.stack([r, rho * lit, area])]), ((0, 0), (reach, reach), (reach, reach)), "edge"
    )
    total, weighted = np.zeros_like(r), np.zeros_like(r)
    for radius, inner, outer in _RINGS:
        fraction = np.float32(np.pi * (outer**2 - inner**2) / len(_WAYS))
        for x, y in _WAYS:
            row, column = reach + round(radius * y), reach + round(radius * x)
            other = patch[:, row : row + r.shape[0], column : column + r.shape[1]]
            power, longer = _by_way_of(other, points, n, r, fraction)
            total += power
            weighted += power * longer
    direct = total + lit
    bias = np.divide(weighted, direct, out=np.zeros_like(r), where=direct > 0)
    return cv2.resize(bias, depth.shape[::-1], interpolation=cv2.INTER_LINEAR)


def _by_way_of(
    other: Float32[np.ndarray, "9 h w"],
    points: Float32[np.ndarray, "3 h w"],
    normals: Float32[np.ndarray, "3 h w"],
    r: Image,
    fraction: np.float32,
) -> tuple[Image, Image]:
    """Return the light that points get by way of patches, and how much longer its way is (m)."""
    way = other[:3] - points
    squared = np.maximum(_dot(way, way), np.float32(1e-6))
    at_point = np.maximum(_dot(way, normals), np.float32(0.0))
    at_patch = np.maximum(-_dot(way, other[3:6]), np.float32(0.0))
    area = fraction * other[8]
    factor = at_point * at_patch * area / (squared * (np.float32(np.pi) * squared + area))
    longer = np.float32(0.5) * (other[6] + np.sqrt(squared) - r)
    return other[7] * factor, np.maximum(longer, np.float32(0.0))


def _dot(a: Float32[np.ndarray, "3 h w"], b: Float32[np.ndarray, "3 h w"]) -> Image:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def added(light: Image, ranges: Image, turn: float) -> tuple[Image, Image]:
    """Return real and imaginary part of light that went a way.

    Args:
        light: Its strength.
        ranges: Half the length of the way there and back (m).
        turn: Phase per range (rad/m).
    """
    real, imaginary = cv2.polarToCart(light, np.float32(turn) * ranges)
    return real, imaginary


def gathered(image: Image, spot_px: float) -> Image:
    """Return the sum over the spot that a pixel gathers light from, a Gaussian of ``spot_px`` (px); 0 = the pixel."""
    if spot_px == 0:
        return image
    size = 2 * int(np.ceil(2.0 * spot_px)) + 1
    kernel = cv2.getGaussianKernel(size, spot_px, cv2.CV_32F)
    blurred: Image = cv2.sepFilter2D(image, cv2.CV_32F, kernel, kernel)
    return blurred


def scattered(real: Image, imaginary: Image, fraction: float) -> tuple[np.float32, np.float32]:
    """Return what a lens and sensor scatter over the whole image: a fraction of the mean of its light.

    The spread of real lenses is wide and flat enough that one constant corrects most of it (Mure-Dubois & Huegli 2007,
    "Real-time scattering compensation for time-of-flight camera", use a few very broad Gaussians).
    """
    return np.float32(fraction * float(real.mean())), np.float32(fraction * float(imaginary.mean()))


def read_off(real: Image, imaginary: Image, ranges: Image, turn: float) -> Image:
    """Return by how much the phase of a sum differs from that of ``ranges`` (m), by the shorter way round."""
    off = cv2.phase(real, imaginary)
    off -= np.float32(turn) * ranges
    full = np.float32(2.0 * np.pi)
    off -= full * np.rint(off / full)
    return off / np.float32(turn)
