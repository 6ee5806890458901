"""Joining the dashes of lines that are thinner than a pixel.

Such a line lies on the centre of some pixels and between those of others: what is drawn of it are dashes. Where one
ends and where the next begins its borders are known to 1/100 px (``antialias.py``), so that it is known
how much of the line the pixels between hold, which show what is behind.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int, UInt32

_FARTHEST = 40
"""Longest gap (px): the line falls by a pixel within it."""
_ALIKE = 0.3
"""Difference between the widths (px) up to which two dashes are of one line,"""
_AS_FAR = 0.03
"""and between their distances, relative."""
_STRAIGHT = 0.25
"""How far the next dash may lie beside where this one points to (px), and"""
_BACK = 6
"""from how many pixels back on it is known where that is."""
_SHORT = 3
"""Gaps (px) over which lines steeper than a pixel a pixel or so need not show where they point to."""
_SAME_COLOUR = 48
"""And sum of the differences of their three codes."""


@dataclass(frozen=True, eq=False)
class Strips:
    """Pixels that two borders cross along one axis, less than a pixel apart."""

    pixels: Int[np.ndarray, " n"]
    """Numbers, row after row, rising."""
    width: Float32[np.ndarray, " n"]
    """Between the borders (px)."""
    offset: Float32[np.ndarray, " n"]
    """From the pixel's centre to their middle, forth along the axis (px)."""
    across: int
    """From a pixel to the next along the axis that the borders cross."""


@dataclass(frozen=True, eq=False)
class Joined:
    """What pixels in gaps take of the dashes beside them."""

    taking: Int[np.ndarray, " m"]
    giving: Int[np.ndarray, " m"]
    fraction: Float32[np.ndarray, " m"]
    width: Float32[np.ndarray, " m"]
    """Of the line there (px)."""


def joined(
    strips: Strips,
    size: tuple[int, int],
    nearness: Float32[np.ndarray, " p"],
    colors: UInt32[np.ndarray, " p"],
    number: Int[np.ndarray, " p"],
) -> Joined:
    """Return what the pixels between dashes of one line hold of it.

    Args:
        strips: Where it is seen.
        size: Width and height of the image.
        nearness: Of its pixels; larger is nearer.
        colors: Red, green and blue of each, in the lowest three bytes.
        number: Used up.
    """
    number[:] = -1
    number[strips.pixels] = np.arange(len(strips.pixels))
    along = size[0] + 1 - strips.across  # one of the two is 1, the other the width
    side = np.where(strips.offset >= 0.0, 1, -1)
    room = _room(strips, size, side)
    left = np.flatnonzero(room > 1)
    ahead = strips.pixels[left] + along
    goes_on = (number[ahead] >= 0) | (number[ahead + side[left] * strips.across] >= 0)
    left = left[~goes_on]
    slope = _slope(strips, left, along, number)
    gaps = np.arange(2, _FARTHEST)
    beyond = strips.pixels[left] + side[left] * strips.across
    # What lies outside of the image is looked up at its last pixel, and not counted.
    places = np.minimum(beyond[:, None] + gaps * along, len(number) - 1)
    seen = (number[places] >= 0) & (room[left][:, None] > gaps)
    meets, first = seen.any(axis=1), seen.argmax(axis=1)
    order = np.flatnonzero(meets)[np.argsort(first[meets], kind="stable")]
    left, gap, slope = left[order], gaps[first[order]], slope[order]
    found = number[places[order, first[order]]]
    pointed = strips.offset[left] + slope * gap - side[left] - strips.offset[found]
    straight = (np.abs(pointed) < _STRAIGHT) | (np.isnan(slope) & (gap <= _SHORT))
    of_one_line = straight & _alike(strips, left, found, side, nearness, colors)
    pairs = left[of_one_line], found[of_one_line], gap[of_one_line]
    return _between(strips, along, side, nearness, pairs)


def _room(strips: Strips, size: tuple[int, int], side: Int[np.ndarray, " n"]) -> Int[np.ndarray, " n"]:
    """Return how many pixels lie ahead of each in the image; none where there is none to its side."""
    row, column = np.divmod(strips.pixels, size[0])
    ahead, beside, last = (size[1] - row, column, size[0]) if strips.across == 1 else (size[0] - column, row, size[1])
    return np.where((beside + side >= 0) & (beside + side < last), ahead, 0)


def _slope(
    strips: Strips, ends: Int[np.ndarray, " k"], along: int, number: Int[np.ndarray, " p"]
) -> Float32[np.ndarray, " k"]:
    """Return by how much the line moves across with each pixel along (px), by the dash before its end; NaN if short."""
    slope = np.full(len(ends), np.nan, np.float32)
    for back in range(_BACK, 0, -1):
        before = strips.pixels[ends] - back * along
        found = np.where(before >= 0, number[np.maximum(before, 0)], -1)
        known = np.isnan(slope) & (found >= 0)
        slope[known] = (strips.offset[ends[known]] - strips.offset[found[known]]) / back
    return slope


def _alike(
    strips: Strips,
    start: Int[np.ndarray, " k"],
    end: Int[np.ndarray, " k"],
    side: Int[np.ndarray, " n"],
    nearness: Float32[np.ndarray, " p"],
    colors: UInt32[np.ndarray, " p"],
) -> np.ndarray:
    """Return which pairs of dashes are of one line, that leaves a row of pixels at one side and enters the next."""
    a, b = strips.pixels[start], strips.pixels[end]
    same = (strips.offset[end] * side[start] <= 0.0) & (np.abs(strips.width[start] - strips.width[end]) < _ALIKE)
    same &= np.abs(nearness[a] - nearness[b]) < _AS_FAR * nearness[a]
    codes = [colors[pixels].view(np.uint8).reshape(-1, 4)[:, :3].astype(int) for pixels in (a, b)]
    return same & (np.abs(codes[0] - codes[1]).sum(axis=1) < _SAME_COLOUR)


def _between(
    strips: Strips,
    along: int,
    side: Int[np.ndarray, " n"],
    nearness: Float32[np.ndarray, " p"],
    pairs: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> Joined:
    """Return what the two rows of pixels between each pair of dashes hold, if nothing nearer is there."""
    start, end, gap = (np.repeat(part, pairs[2] - 1) for part in pairs)
    first = np.cumsum(pairs[2] - 1) - (pairs[2] - 1)
    step = np.arange(len(gap)) - np.repeat(first, pairs[2] - 1) + 1
    t = (step / gap).astype(np.float32)
    width = (1.0 - t) * strips.width[start] + t * strips.width[end]
    middle = (1.0 - t) * strips.offset[start] + t * (side[start] + strips.offset[end])
    giving = strips.pixels[np.where(t < 0.5, start, end)]
    taking, fraction = [], []
    for row in (0, 1):
        centre = row * side[start]
        pixel = strips.pixels[start] + step * along + row * side[start] * strips.across
        low, high = np.maximum(middle - width / 2, centre - 0.5), np.minimum(middle + width / 2, centre + 0.5)
        free = nearness[pixel] <= nearness[giving] * (1.0 + _AS_FAR)
        taking.append(pixel)
        fraction.append(np.where(free, np.maximum(high - low, 0.0), 0.0).astype(np.float32))
    return Joined(np.concatenate(taking), np.tile(giving, 2), np.concatenate(fraction), np.tile(width, 2))
