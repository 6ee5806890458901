"""Camera rays and numbers that spread evenly: Sobol points, shuffled and scrambled again for each pixel and sample.

Burley 2020, "Practical hash-based Owen scrambling": every draw of a path takes one or two dimensions of the (0, 2)
sequence; Owen's scrambling, by Vegdahl's hash, keeps a pixel's points even and makes those of two draws or two pixels
independent. Any number of points may be taken, in any number of passes; powers of two are spread best.
"""

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform


@dataclass
class SobolSampler:
    """One point of a sequence for each path, one or two dimensions of it a draw.

    Its arrays are public, so that Dr.Jit finds them in a loop.
    """

    place: Any = None
    """``mi.UInt32``: number of the path in its pixel, bits reversed."""
    key: Any = None
    """``mi.UInt32``: what tells this draw of this pixel from all others."""

    def next_1d(self) -> Any:
        """Return an ``mi.Float`` from 0 to below 1 for each path."""
        order, across, _ = self._keys()
        return _unit(_scrambled(_mixed(self.place, order), across))

    def next_2d(self) -> Any:
        """Return an ``mi.Point2f`` in the unit square for each path."""
        order, across, up = self._keys()
        place = _mixed(self.place, order)
        return mi.Point2f(_unit(_scrambled(place, across)), _unit(_scrambled(second_dimension(place), up)))

    def _keys(self) -> tuple[Any, Any, Any]:
        self.key = _hashed(self.key + 0x9E3779B9)
        return self.key, _hashed(self.key ^ 0x5BD1E995), _hashed(self.key ^ 0x2545F491)


def sobol_sampler(seed: int, pixel: Any, number: Any) -> SobolSampler:
    """Return the sampler of paths.

    Args:
        seed: Of the image, 0 to 2^32 - 1.
        pixel: ``mi.UInt32``, the pixel of each path.
        number: ``mi.UInt32``, which of its pixel's paths each is.
    """
    return SobolSampler(dr.brev(number), _hashed(_hashed(pixel) + dr.opaque(mi.UInt32, seed)))


def second_dimension(place: Any) -> Any:
    """Return the second coordinate (32 bits) of the Sobol points whose first is ``place``.

    The product with Pascal's matrix modulo 2 (Ahmed 2024, "An implementation algorithm of 2D Sobol sequence").
    """
    place = place ^ (place << 16)
    place = place ^ ((place & 0x00FF00FF) << 8)
    place = place ^ ((place & 0x0F0F0F0F) << 4)
    place = place ^ ((place & 0x33333333) << 2)
    return place ^ ((place & 0x55555555) << 1)


def _mixed(bits: Any, key: Any) -> Any:
    """Return ``bits`` with each one flipped or not by a hash of those below it (Laine and Karras 2011; Vegdahl)."""
    bits = bits ^ (bits * 0x3D20ADEA)
    bits = bits + key
    bits = bits * ((key >> 16) | 1)
    bits = bits ^ (bits * 0x05526C56)
    return bits ^ (bits * 0x53A22864)


def _scrambled(place: Any, key: Any) -> Any:
    return dr.brev(_mixed(dr.brev(place), key))


def _hashed(value: Any) -> Any:
    """Return 32 bits that look random (Wellons 2018, "Prospecting for hash functions", lowbias32)."""
    value = (value ^ (value >> 16)) * 0x7FEB352D
    value = (value ^ (value >> 15)) * 0x846CA68B
    return value ^ (value >> 16)


def _unit(bits: Any) -> Any:
    return mi.Float(bits >> 8) * 2.0**-24


def camera_rays(
    camera: PinholeCamera, T_world_camera: Transform, seed: int, first: int, count: int
) -> "tuple[mi.Ray3f, SobolSampler]":
    """Return unit rays, ``count`` a pixel, one pixel after the other, and the sampler that goes on with their paths.

    Args:
        camera: Intrinsics.
        T_world_camera: Pose of the camera.
        seed: Of all random numbers.
        first: Number of the first path of each pixel: those of an image are spread evenly over the square.
        count: Paths a pixel.
    """
    path = dr.arange(mi.UInt32, camera.width * camera.height * count)
    per_pixel = dr.opaque(mi.UInt32, count)
    pixel = path // per_pixel
    sampler = sobol_sampler(seed, pixel, path - pixel * per_pixel + dr.opaque(mi.UInt32, first))
    row = pixel // camera.width
    column = pixel - row * camera.width
    jitter = sampler.next_2d() - 0.5
    x = (mi.Float(column) + jitter.x - camera.cx) / camera.fx
    y = (mi.Float(row) + jitter.y - camera.cy) / camera.fy
    axes: list[Any] = [mi.Vector3f(*map(float, T_world_camera[:3, axis])) for axis in range(4)]
    right, down, forward, origin = axes
    return mi.Ray3f(mi.Point3f(origin), dr.normalize(right * x + down * y + forward)), sampler
