"""A matcher of the kind that active stereo cameras have in hardware: census, windows, scanlines, checks, fractions.

Keselman et al. 2017, "Intel RealSense stereoscopic depth cameras" (arXiv 1705.05548): census costs, left against right,
threshold on the second peak, median. The census of 9 x 9 pixels and its successor's optimisation along scanlines are
named by the settings of D400 cameras (``param-censususize: 9``, ``param-usersm``). Penalties and thresholds are those
of this matcher: the hardware's are in units that are not public. Fractions of pixels are found by least squares (Lucas
& Kanade 1981), as fits to costs of bits are several times worse than what is published of these cameras.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float32, UInt8, UInt64

Cost = Float32[np.ndarray, "h w d"]


@dataclass(frozen=True)
class Matcher:
    """Settings."""

    disparities: int = 96
    """How many are compared (px)."""
    census_px: int = 9
    """Edge of the window (px)."""
    window_px: int = 7
    """Edge of the window over which bits are averaged (px), and of that of the least squares."""
    small_step: float = 4.0
    """Penalty of a step of one pixel, in differing bits."""
    large_step: float = 24.0
    """Penalty of a larger step, in differing bits."""
    second_peak: float = 0.10
    """By which share the best cost must beat all that are not beside it."""
    left_right_px: float = 1.0
    """Largest difference between matching from the left and from the right (px)."""
    least_alike: float = 0.42
    """Fraction of bits that may differ at the best place."""


def match(left: UInt8[np.ndarray, "h w"], right: UInt8[np.ndarray, "h w"], how: Matcher) -> Float32[np.ndarray, "h w"]:
    """Return the disparity (px) of the left image, 0 = none."""
    raw = _census_costs(left, right, how)
    cost = _along_scanlines(raw, how)
    best = cost.argmin(axis=-1)
    kept = _unique(cost, best, how.second_peak) & _both_ways(cost, best, how.left_right_px)
    bits = how.census_px**2 - 1
    kept &= np.take_along_axis(raw, best[..., None], axis=-1)[..., 0] < how.least_alike * bits
    kept &= (best > 0) & (best <= np.arange(left.shape[1]))
    found = (best + _fraction(cost, best)).astype(np.float32)
    for _ in range(3):
        found = _refined(left, right, found, kept, how.window_px + 2)
    return _without_specks(np.where(kept, found, np.float32(0.0)))


def _census(image: UInt8[np.ndarray, "h w"], size: int) -> list[UInt64[np.ndarray, "h w"]]:
    """Return whether each neighbour is brighter than the middle, 64 bits a word."""
    reach, (height, width) = size // 2, image.shape
    padded = cv2.copyMakeBorder(image, reach, reach, reach, reach, cv2.BORDER_REPLICATE)
    places = [(v, u) for v in range(size) for u in range(size) if (v, u) != (reach, reach)]
    words = []
    for start in range(0, len(places), 64):
        word = np.zeros(image.shape, np.uint64)
        for bit, (v, u) in enumerate(places[start : start + 64]):
            word |= (padded[v : v + height, u : u + width] > image).astype(np.uint64) << np.uint64(bit)
        words.append(word)
    return words


def _census_costs(left: UInt8[np.ndarray, "h w"], right: UInt8[np.ndarray, "h w"], how: Matcher) -> Cost:
    """Return how many bits differ between each left pixel and each of its candidates."""
    words = [_census(image, how.census_px) for image in (left, right)]
    costs = np.full((*left.shape, how.disparities), how.census_px**2 - 1.0, np.float32)
    for shift in range(min(how.disparities, left.shape[1])):
        costs[:, shift:, shift] = sum(
            np.bitwise_count(one[:, shift:] ^ other[:, : other.shape[1] - shift])
            for one, other in zip(*words, strict=True)
        )
    for shift in range(how.disparities):
        costs[..., shift] = cv2.blur(np.ascontiguousarray(costs[..., shift]), (how.window_px, how.window_px))
    return costs


def _along_scanlines(costs: Cost, how: Matcher) -> Cost:
    """Return costs summed along four directions, steps of disparity penalised (Hirschmueller 2008), over four."""
    total = np.zeros_like(costs)
    for axis in (0, 1):
        for backwards in (False, True):
            lines = np.moveaxis(costs, axis, 0)[:: -1 if backwards else 1]
            summed = np.moveaxis(total, axis, 0)[:: -1 if backwards else 1]
            path = lines[0].copy()
            summed[0] += path
            for index in range(1, len(lines)):
                least = path.min(axis=-1, keepdims=True)
                stepped = np.minimum(path, least + how.large_step)
                stepped[..., 1:] = np.minimum(stepped[..., 1:], path[..., :-1] + how.small_step)
                stepped[..., :-1] = np.minimum(stepped[..., :-1], path[..., 1:] + how.small_step)
                path = lines[index] + stepped - least
                summed[index] += path
    return total / np.float32(4.0)


def _fraction(cost: Cost, best: np.ndarray) -> Float32[np.ndarray, "h w"]:
    """Return where between its neighbours the least cost lies, -0.5 to 0.5 px: two lines of equal slope (Haller 2010).

    Costs of absolute differences and of bits grow linearly, so that a parabola would prefer whole pixels.
    """
    last = cost.shape[-1] - 1
    before, here, after = (
        np.take_along_axis(cost, np.clip(best + step, 0, last)[..., None], axis=-1)[..., 0] for step in (-1, 0, 1)
    )
    rise = np.maximum(np.maximum(before, after) - here, 1e-6)
    shift: Float32[np.ndarray, "h w"] = 0.5 * (before - after) / rise
    return shift.astype(np.float32)


def _refined(
    left: UInt8[np.ndarray, "h w"], right: UInt8[np.ndarray, "h w"], found: Float32[np.ndarray, "h w"],
    kept: Bool[np.ndarray, "h w"], size: int,
) -> Float32[np.ndarray, "h w"]:  # fmt: skip
    """Return disparities after one step of least squares over windows, whose pixels bring their own disparity."""
    height, width = left.shape
    v, u = np.mgrid[:height, :width].astype(np.float32)
    warped = cv2.remap(right.astype(np.float32), u - found, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    one, other = (image - cv2.blur(image, (size, size)) for image in (left.astype(np.float32), warped))
    slope = cv2.Sobel(other, cv2.CV_32F, 1, 0, ksize=1) / np.float32(2.0)
    weight = slope * slope * kept
    top = cv2.blur(weight * found - kept * slope * (one - other), (size, size))
    stepped = top / np.maximum(cv2.blur(weight, (size, size)), np.float32(1e-3))
    return np.where(np.abs(stepped - found) < 1.0, stepped, found).astype(np.float32)


def _unique(cost: Cost, best: np.ndarray, fraction: float) -> Bool[np.ndarray, "h w"]:
    """Return where no disparity that is not beside the best is nearly as good."""
    least = np.take_along_axis(cost, best[..., None], axis=-1)[..., 0]
    others = np.where(np.abs(np.arange(cost.shape[-1]) - best[..., None]) > 2, cost, np.inf).min(axis=-1)
    unique: Bool[np.ndarray, "h w"] = least < (1.0 - fraction) * others
    return unique


def _both_ways(cost: Cost, best: np.ndarray, max_px: float) -> Bool[np.ndarray, "h w"]:
    """Return where the right pixel's best candidate is the left pixel, too."""
    _, width, count = cost.shape
    mirrored = np.full(cost.shape, np.inf, np.float32)
    for shift in range(min(count, width)):
        mirrored[:, : width - shift, shift] = cost[:, shift:, shift]
    there = np.clip(np.arange(width) - best, 0, width - 1)
    agreed: Bool[np.ndarray, "h w"] = (
        np.abs(np.take_along_axis(mirrored.argmin(axis=-1), there, axis=1) - best) <= max_px
    )
    return agreed


def _without_specks(disparity: Float32[np.ndarray, "h w"]) -> Float32[np.ndarray, "h w"]:
    """Return disparities without patches of less than twenty pixels."""
    steps = np.rint(disparity * 16.0).astype(np.int16)
    cv2.filterSpeckles(steps, 0, 20, 16)
    return np.where(steps > 0, disparity, np.float32(0.0))
