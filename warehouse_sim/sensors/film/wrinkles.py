"""Wrinkles of stretch film: slopes of its surface that are finer than its mesh, and stay where they are.

Film pulled tight lies in fine waves that run slantwise along the pull, here more of them and there fewer. Widths and
slopes have no source: priors by eye.
"""

from functools import lru_cache

import numpy as np
from jaxtyping import Float32, Int32

_TEXELS = 256
_TEXEL = 0.004
"""Edge of a texel (m); the tile starts again each 1.024 m."""
_SLOPE = 0.11
"""Root mean square of the slope across the waves (rad)."""
_WAVES = ((18.0, 0.020, 0.22), (-25.0, 0.014, 0.15), (80.0, 0.030, 0.25))
"""Of each family: where it runs (deg above level), width and length of its waves (m)."""
_PATCH = 0.12
"""Size of the patches with more waves or fewer (m)."""


def wrinkled(
    points: Float32[np.ndarray, "n 3"], normals: Float32[np.ndarray, "n 3"], instance_ids: Int32[np.ndarray, " n"]
) -> Float32[np.ndarray, "n 3"]:
    """Return the normals of the wrinkles at places on film.

    Each object's tile begins elsewhere; it is laid on along the world axis that the film faces most.

    Args:
        points: World (m).
        normals: Unit, of the mesh.
        instance_ids: Whose film it is.
    """
    x, y, z = points.T
    across, along, upright = np.abs(normals.T)
    faces_z = upright > np.maximum(across, along)
    faces_x = (across > along) & ~faces_z
    start = instance_ids.astype(np.int64)
    u = np.floor(np.where(faces_x, y, x) * np.float32(1.0 / _TEXEL)).astype(np.int64) + 97 * start
    v = np.floor(np.where(faces_z, y, z) * np.float32(1.0 / _TEXEL)).astype(np.int64) + 61 * start
    slopes = _slopes()[:, v & (_TEXELS - 1), u & (_TEXELS - 1)]
    turned = normals.T.copy()
    turned[0] -= np.where(faces_x, np.float32(0.0), slopes[0])
    turned[1] -= np.where(faces_x, slopes[0], np.where(faces_z, slopes[1], np.float32(0.0)))
    turned[2] -= np.where(faces_z, np.float32(0.0), slopes[1])
    turned /= np.sqrt(np.square(turned).sum(axis=0))
    return turned.T


@lru_cache(maxsize=1)
def _slopes() -> Float32[np.ndarray, "2 t t"]:
    """Return the slopes along u and v of a tile that fits itself."""
    rng = np.random.default_rng(0x66696C6D)
    fu, fv = np.meshgrid(*(np.fft.fftfreq(_TEXELS, _TEXEL),) * 2)
    height = np.zeros((_TEXELS, _TEXELS))
    for degrees, width, length in _WAVES:
        turn = np.deg2rad(degrees)
        run, rise = fu * np.cos(turn) + fv * np.sin(turn), fv * np.cos(turn) - fu * np.sin(turn)
        band = np.exp(-((run * length) ** 2)) * np.exp(-(((np.abs(rise) * width - 0.5) / 0.25) ** 2))
        height += _filtered(rng, band) * _filtered(rng, np.exp(-((fu**2 + fv**2) * _PATCH**2))) ** 2 * width
    spectrum = np.fft.fft2(height)
    slopes = np.array([np.fft.ifft2(2j * np.pi * f * spectrum).real for f in (fu, fv)])
    slopes *= _SLOPE / np.sqrt(np.square(slopes).sum(axis=0).mean())
    fixed: Float32[np.ndarray, "2 t t"] = slopes.astype(np.float32)
    fixed.setflags(write=False)
    return fixed


def _filtered(rng: np.random.Generator, band: np.ndarray) -> np.ndarray:
    """Return noise of variance 1 with a given spectrum."""
    noise = np.fft.ifft2(np.fft.fft2(rng.standard_normal(band.shape)) * band).real
    return np.asarray(noise / noise.std())
