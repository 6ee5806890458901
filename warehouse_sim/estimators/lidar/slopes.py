"""The readings of a sparse depth image with the slope of the surface that each lies on.

The inverse depth of a plane is linear in the pixel: with n . X = d and X = z r, 1 / z = n . r / d.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Float32, Int

_HOLD = 6.0
"""The slope is held at 0 as strongly as by a neighbour of weight 1 this far away (px)."""
_MOST_CHANGE = 0.3
"""A reading says of no pixel of the window that its inverse depth differs by more than this fraction."""


@dataclass(frozen=True, eq=False)
class Samples:
    """n readings of a padded image."""

    place: Int[np.ndarray, " n"]
    """Row-major place in it."""
    depth: Float32[np.ndarray, " n"]
    """Metres along the optical axis."""
    half_h: int
    """Rows of padding."""
    half_w: int
    """Columns of padding."""
    inverse: Float32[np.ndarray, " n"]
    """Inverse depth (1/m)."""
    slope: Float32[np.ndarray, "2 n"]
    """Change of the inverse depth (1/m) from a pixel to the one on its right, and to the one below."""

    @classmethod
    def of(cls, padded: Float32[np.ndarray, "h w"], half_h: int, half_w: int) -> "Samples":
        """Return the readings of an image."""
        place = np.flatnonzero(padded)
        depth = padded.ravel()[place]
        return cls(place, depth, half_h, half_w, 1.0 / depth, np.zeros((2, len(place)), np.float32))

    def inverse_beside(self, down: int, right: int) -> Float32[np.ndarray, " n"]:
        """Return what each says of the inverse depth (1/m) of the pixel some rows below and columns to its right."""
        return self.inverse + (self.slope[0] * np.float32(right) + self.slope[1] * np.float32(down))


def with_slopes(samples: Samples, padded: Float32[np.ndarray, "h w"], step: float, step_fraction: float) -> Samples:
    """Return the readings with slopes, by least squares of the inverse depths of their neighbours.

    Args:
        samples: The readings.
        padded: The image that they are of.
        step: Neighbours that differ by more are of another surface (m) ...
        step_fraction: ... at zero range, and by this fraction of the range more.
    """
    number = np.full(padded.size, -1, dtype=np.int32)
    number[samples.place] = np.arange(len(samples.place), dtype=np.int32)
    inverse, reach = (1.0 / samples.depth).astype(np.float64), step + step_fraction * samples.depth
    moments = np.zeros((5, len(samples.place)))
    for down in range(-samples.half_h, samples.half_h + 1):
        for right in range(-samples.half_w, samples.half_w + 1):
            if down == right == 0:
                continue
            other = number[samples.place + (down * padded.shape[1] + right)]
            one = np.flatnonzero(other >= 0)
            other = other[one]
            one, other = _of_one_surface(samples.depth, reach, one, other)
            difference = inverse[other] - inverse[one]
            moments[:, one] += np.stack(np.broadcast_arrays(
                right * right, right * down, down * down, right * difference, down * difference
            ))  # fmt: skip
    most = _MOST_CHANGE * inverse / (samples.half_h + samples.half_w)
    return replace(samples, slope=np.clip(_solved(moments), -most, most).astype(np.float32))


def _of_one_surface(
    depth: Float32[np.ndarray, " n"],
    reach: Float[np.ndarray, " n"],
    one: Int[np.ndarray, " m"],
    other: Int[np.ndarray, " m"],
) -> tuple[Int[np.ndarray, " k"], Int[np.ndarray, " k"]]:
    near = np.abs(depth[other] - depth[one]) <= reach[one]
    return one[near], other[near]


def _solved(moments: Float[np.ndarray, "5 n"]) -> Float[np.ndarray, "2 n"]:
    """Return the slopes of the normal equations of two unknowns, which are held at 0 a little."""
    uu, uv, vv, uq, vq = moments
    uu, vv = uu + _HOLD**2, vv + _HOLD**2
    determinant = uu * vv - uv**2
    across, down = (vv * uq - uv * vq) / determinant, (uu * vq - uv * uq) / determinant
    return np.stack([across, down])
