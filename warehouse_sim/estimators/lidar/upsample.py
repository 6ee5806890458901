"""A sweep's sparse depth image filled up by a bilateral filter that keeps foreground and background apart.

After Premebida et al., "High-resolution LiDAR-based depth mapping using bilateral filter" (ITSC 2016): a sliding window
with spatial and range weights, whose range term decides for one surface where the window sees several. Ours differs in
that samples bring their slope, so that floors and turned fronts do not become stairs, and in how a surface is chosen.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, Int

WIDTH_PX, HEIGHT_PX = 9, 15
"""Size of the window, odd, for 64 beams and a focal length of 700 px: it holds four columns of a sweep with 0.17 deg
between them, and at least two beams that are 0.5 deg apart, off the axis, too."""
_STEP, _STEP_FRACTION = 0.3, 0.05
"""Readings of a window that differ by more are of two surfaces (m): at zero range, and by this fraction of it more."""
_SAME, _SAME_FRACTION = 0.1, 0.02
"""Readings that are averaged differ by less from the one that was chosen (m): at zero range, and by this fraction of it
more."""
_LEAST_READINGS = 3
"""Readings that the window must hold."""
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


def with_slopes(samples: Samples, padded: Float32[np.ndarray, "h w"]) -> Samples:
    """Return the readings with slopes, by least squares of the inverse depths of their neighbours.

    Args:
        samples: The readings.
        padded: The image that they are of.
    """
    number = np.full(padded.size, -1, dtype=np.int32)
    number[samples.place] = np.arange(len(samples.place), dtype=np.int32)
    inverse, reach = (1.0 / samples.depth).astype(np.float64), _STEP + _STEP_FRACTION * samples.depth
    moments = np.zeros((5, len(samples.place)))
    for down in range(-samples.half_h, samples.half_h + 1):
        for right in range(-samples.half_w, samples.half_w + 1):
            if down == right == 0:
                continue
            other = number[samples.place + (down * padded.shape[1] + right)]
            one = np.flatnonzero(other >= 0)
            other = other[one]
            near = np.abs(samples.depth[other] - samples.depth[one]) <= reach[one]
            one, other = one[near], other[near]
            difference = inverse[other] - inverse[one]
            moments[:, one] += np.stack(np.broadcast_arrays(
                right * right, right * down, down * down, right * difference, down * difference
            ))  # fmt: skip
    most = _MOST_CHANGE * inverse / (samples.half_h + samples.half_w)
    return replace(samples, slope=np.clip(_solved(moments), -most, most).astype(np.float32))


def _solved(moments: Float[np.ndarray, "5 n"]) -> Float[np.ndarray, "2 n"]:
    """Return the slopes of the normal equations of two unknowns, which are held at 0 a little."""
    uu, uv, vv, uq, vq = moments
    uu, vv = uu + _HOLD**2, vv + _HOLD**2
    determinant = uu * vv - uv**2
    across, down = (vv * uq - uv * vq) / determinant, (uu * vq - uv * uq) / determinant
    return np.stack([across, down])


def upsample(
    sparse: Float32[np.ndarray, "h w"],
    height_px: int = HEIGHT_PX,
) -> Float32[np.ndarray, "h w"]:
    """Return a dense depth image (m, 0 = too few readings about it) of a sparse one (m, 0 = no reading).

    A pixel whose window holds readings that differ by a step is of the surface that has more weight there, of the
    nearer one in uncertainty. Its depth is the mean, in inverse depth and weighted by distance in the image, of what
    the readings of that surface say of it, each along its own slope. No depth lies between two surfaces.

    Args:
        sparse: Most pixels have no reading.
        height_px: Height of the window, odd; of fewer beams more than ``HEIGHT_PX``.
    """
    if height_px % 2 == 0:
        raise ValueError(f"the window must have odd sides, found {height_px} px")
    half_h, half_w = height_px // 2, WIDTH_PX // 2
    padded = np.pad(np.asarray(sparse, dtype=np.float32), ((half_h, half_h), (half_w, half_w)))
    samples = Samples.of(padded, half_h, half_w)
    if not len(samples.place):
        return np.zeros_like(sparse, dtype=np.float32)
    window, samples = _Window(padded, height_px), with_slopes(samples, padded)
    dense = window.mean(samples, window.nearest(samples, window.vote(samples)))
    dense[~window.surrounded()] = 0.0
    return np.ascontiguousarray(dense[half_h:-half_h, half_w:-half_w])


class _Window:
    """The window about every pixel of a padded image; loops run over its places, arrays over the readings."""

    def __init__(self, padded: Float32[np.ndarray, "h w"], height_px: int) -> None:
        self._depth = padded
        size = height_px, WIDTH_PX
        down, right = np.mgrid[: size[0], : size[1]] - np.array([size[0] // 2, size[1] // 2])[:, None, None]
        weight = np.exp(-0.5 * ((4.0 * down / size[0]) ** 2 + (4.0 * right / size[1]) ** 2)).astype(np.float32)
        order = np.argsort(weight, axis=None, kind="stable")
        self._places = [(int(down.flat[i]), int(right.flat[i]), weight.flat[i]) for i in order]
        """Rows down, columns right and weight, the least weight first."""
        self._kernel = weight

    def vote(self, samples: Samples) -> list[Bool[np.ndarray, " n"]]:
        """Return for each place of the window which readings are of the surface of the pixel that lies there."""
        depth = self._depth
        box, far = np.ones(self._kernel.shape, np.uint8), float(np.finfo(np.float32).max)
        least = cv2.erode(np.where(depth > 0, depth, far), box, borderType=cv2.BORDER_CONSTANT, borderValue=far)
        most = cv2.dilate(depth, box, borderType=cv2.BORDER_CONSTANT, borderValue=0.0)
        stepped = (most - least > _STEP + _STEP_FRACTION * least) & (most > 0)
        # Where nothing steps all readings are near.
        middle = np.where(stepped, 0.5 * (least + most), far).astype(np.float32).ravel()
        total = cv2.filter2D((depth > 0).astype(np.float32), -1, self._kernel, borderType=cv2.BORDER_CONSTANT).ravel()
        near, sides = np.zeros(depth.size, np.float32), []
        for down, right, weight in self._places:
            at = samples.place + (down * depth.shape[1] + right)
            sides.append(samples.depth < middle.take(at))
            near[at] += weight * sides[-1]
        is_near = near >= 0.5 * total
        places = zip(self._places, sides, strict=True)
        return [
            side == is_near.take(samples.place + (down * depth.shape[1] + right)) for (down, right, _), side in places
        ]

    def nearest(self, samples: Samples, belongs: list[Bool[np.ndarray, " n"]]) -> Float32[np.ndarray, " p"]:
        """Return what the nearest reading of its surface says of each pixel's inverse depth (1/m); 0 where none is."""
        found = np.zeros(self._depth.size, np.float32)
        for (down, right, _), belonging in zip(self._places, belongs, strict=True):
            taken = np.flatnonzero(belonging)
            at = samples.place.take(taken) + (down * self._depth.shape[1] + right)
            found[at] = samples.inverse_beside(down, right).take(taken)
        return found

    def mean(self, samples: Samples, reference: Float32[np.ndarray, " p"]) -> Float32[np.ndarray, "h w"]:
        """Return the mean depth (m) of the readings that agree with each pixel's reference; 0 where there is none."""
        shape = self._depth.shape
        depth = 1.0 / np.maximum(reference, 1e-6)
        # A difference of inverse depths is one of depths over the depth's square.
        narrow = (depth**2 / (_SAME + _SAME_FRACTION * depth)).astype(np.float32)
        weights, sums = np.zeros(self._depth.size, np.float32), np.zeros(self._depth.size, np.float32)
        for down, right, weight in self._places:
            at = samples.place + (down * shape[1] + right)
            inverse = samples.inverse_beside(down, right)
            # Tukey's biweight: smooth, and exactly nothing beyond its reach.
            fraction = 1.0 - np.square((inverse - reference.take(at)) * narrow.take(at))
            fraction = weight * np.square(np.maximum(fraction, 0.0))
            weights[at] += fraction
            sums[at] += fraction * inverse
        known = (weights > 1e-6) & (reference > 0)
        return np.where(known, weights / np.where(known, sums, 1.0), 0.0).astype(np.float32).reshape(shape)

    def surrounded(self) -> Bool[np.ndarray, "h w"]:
        """Return which pixels have enough readings about them, on both sides and above and below, themselves included.

        What stands before nothing that reflects would else grow by half a window. On one side half the window must
        hold a reading, on the other half as much again may be looked at: beams may be that far apart.
        """
        has, (height, width) = (self._depth > 0).astype(np.float32), self._kernel.shape
        enough = _count(has, height, width, None) >= _LEAST_READINGS - 0.5
        farther = 2 * (3 * height // 4) + 1
        for side in ("left", "right", "up", "down"):
            enough &= _count(has, farther if side in ("up", "down") else height, width, side) >= 0.5
        return enough


def _count(has: Float32[np.ndarray, "h w"], height: int, width: int, side: str | None) -> Float32[np.ndarray, "h w"]:
    """Return how many readings the window of each pixel holds, or that half of it on one side, its middle included."""
    rows = height // 2 + 1 if side in ("up", "down") else height
    columns = width // 2 + 1 if side in ("left", "right") else width
    # Where in the counted box the pixel itself lies.
    at_row = {"up": rows - 1, "down": 0}.get(side or "", rows // 2)
    at_column = {"left": columns - 1, "right": 0}.get(side or "", columns // 2)
    counted = cv2.boxFilter(
        has, -1, (columns, rows), anchor=(at_column, at_row), normalize=False, borderType=cv2.BORDER_CONSTANT
    )
    return np.asarray(counted)
