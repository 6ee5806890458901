"""A sweep's sparse depth image filled up by a bilateral filter that keeps foreground and background apart.

After Premebida et al., "High-resolution LiDAR-based depth mapping using bilateral filter" (ITSC 2016): a sliding window
with spatial and range weights, whose range term decides for one surface where the window sees several. Ours differs in
that samples bring their slope, so that floors and turned fronts do not become stairs, and in how a surface is chosen.
"""

from dataclasses import dataclass
from typing import Annotated

import cv2
import numpy as np
from jaxtyping import Bool, Float32

from warehouse_sim.estimators.lidar.slopes import Samples, with_slopes
from warehouse_sim.ranges import Range, ranged


@dataclass(frozen=True)
@ranged
class UpsampleConfig:
    """How a sparse depth image is filled; the defaults are for 64 beams and a focal length of 700 px."""

    width_px: Annotated[int, Range(3, 101, "px")] = 9
    """Width of the window, 3-101, odd; it holds four columns of a sweep with 0.17 deg between them."""
    height_px: Annotated[int, Range(3, 101, "px")] = 15
    """Height of the window, 3-101, odd; it holds at least two beams that are 0.5 deg apart, off the axis, too."""
    step: Annotated[float, Range(0, 10, "m")] = 0.3
    """Readings of a window that differ by more are of two surfaces (m), 0-10 ..."""
    step_fraction: Annotated[float, Range(0, 1)] = 0.05
    """... at zero range, and by this fraction of the range more, 0-1."""
    same: Annotated[float, Range(1e-3, 10, "m")] = 0.1
    """Readings that are averaged differ by less from the one that was chosen (m), 0.001-10 ..."""
    same_fraction: Annotated[float, Range(0, 1)] = 0.02
    """... at zero range, and by this fraction of the range more, 0-1."""
    least: Annotated[int, Range(1, 100)] = 3
    """Readings that the window must hold, 1-100."""

    def __post_init__(self) -> None:
        if self.width_px % 2 == 0 or self.height_px % 2 == 0:
            raise ValueError(f"the window must have odd sides, found {self.width_px} x {self.height_px} px")


def upsample(
    sparse: Float32[np.ndarray, "h w"],
    config: UpsampleConfig = UpsampleConfig(),
) -> Float32[np.ndarray, "h w"]:
    """Return a dense depth image (m, 0 = too few readings about it) of a sparse one (m, 0 = no reading).

    A pixel whose window holds readings that differ by a step is of the surface that has more weight there, of the
    nearer one in uncertainty. Its depth is the mean, in inverse depth and weighted by distance in the image, of what
    the readings of that surface say of it, each along its own slope. No depth lies between two surfaces.
    """
    half_h, half_w = config.height_px // 2, config.width_px // 2
    padded = np.pad(np.asarray(sparse, dtype=np.float32), ((half_h, half_h), (half_w, half_w)))
    samples = Samples.of(padded, half_h, half_w)
    if not len(samples.place):
        return np.zeros_like(sparse, dtype=np.float32)
    window, samples = _Window(padded, config), with_slopes(samples, padded, config.step, config.step_fraction)
    dense = window.mean(samples, window.nearest(samples, window.vote(samples)))
    dense[~window.surrounded()] = 0.0
    return np.ascontiguousarray(dense[half_h:-half_h, half_w:-half_w])


class _Window:
    """The window about every pixel of a padded image; loops run over its places, arrays over the readings."""

    def __init__(self, padded: Float32[np.ndarray, "h w"], config: UpsampleConfig) -> None:
        self._depth, self._config = padded, config
        size = config.height_px, config.width_px
        down, right = np.mgrid[: size[0], : size[1]] - np.array([size[0] // 2, size[1] // 2])[:, None, None]
        weight = np.exp(-0.5 * ((4.0 * down / size[0]) ** 2 + (4.0 * right / size[1]) ** 2)).astype(np.float32)
        order = np.argsort(weight, axis=None, kind="stable")
        self._places = [(int(down.flat[i]), int(right.flat[i]), weight.flat[i]) for i in order]
        """Rows down, columns right and weight, the least weight first."""
        self._kernel = weight

    def vote(self, samples: Samples) -> list[Bool[np.ndarray, " n"]]:
        """Return for each place of the window which readings are of the surface of the pixel that lies there."""
        config, depth = self._config, self._depth
        box, far = np.ones(self._kernel.shape, np.uint8), float(np.finfo(np.float32).max)
        least = cv2.erode(np.where(depth > 0, depth, far), box, borderType=cv2.BORDER_CONSTANT, borderValue=far)
        most = cv2.dilate(depth, box, borderType=cv2.BORDER_CONSTANT, borderValue=0.0)
        stepped = (most - least > config.step + config.step_fraction * least) & (most > 0)
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
        config, shape = self._config, self._depth.shape
        depth = 1.0 / np.maximum(reference, 1e-6)
        # A difference of inverse depths is one of depths over the depth's square.
        narrow = (depth**2 / (config.same + config.same_fraction * depth)).astype(np.float32)
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
        enough = _count(has, height, width, None) >= self._config.least - 0.5
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
