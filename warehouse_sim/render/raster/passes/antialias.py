"""Antialiasing of colours by the area that faces cover; other images stay those of the pixel centres.

The geometry pass stores how far the face in each pixel reaches (``gbuffer.frag``), so the border between two pixels is
known to about 1/100 px, and a pixel takes from its neighbour the fraction that lies beyond it (Persson 2011, "Geometry
buffer antialiasing"). It costs no second traversal of the scene. On a CPU a list of the few border pixels is cheaper
than a pass over the image.
"""

import numpy as np
from jaxtyping import Float, Float32, Int, UInt8, UInt32

from warehouse_sim.color import linear_from_srgb, srgb_from_linear
from warehouse_sim.render.raster.passes.dashes import Strips, joined

_LEFT, _RIGHT, _TOP, _BOTTOM = range(4)
_STEPS = 4095
_LEAST = 1 / 64  # shares (px) below are not seen
_THINNEST = 0.15  # strips narrower than this (px) are not shown


def _decode() -> Float32[np.ndarray, "256"]:
    """Return the linear value of each displayed one."""
    return linear_from_srgb(np.arange(256) / 255.0).astype(np.float32)


def _encode() -> UInt8[np.ndarray, " s"]:
    """Return the displayed value of linear ones in equal steps from 0 to 1."""
    return np.round(255.0 * srgb_from_linear(np.arange(_STEPS + 1) / _STEPS)).astype(np.uint8)


def _fraction(distance: Float[np.ndarray, " n"], slope: Float[np.ndarray, " n"]) -> Float32[np.ndarray, " n"]:
    """Return the area (px) of a pixel beyond a straight border.

    Args:
        distance: From the centre along the axis that the border runs across (px).
        slope: Tangent of the angle between the border and the other axis, above 0, to 1.
    """
    corner = np.maximum((1 + slope) / 2 - distance, 0.0) ** 2 / (2 * slope)  # the border leaves through this side
    return np.where(distance < (1 - slope) / 2, 0.5 - distance, corner).astype(np.float32)


def _fractions() -> tuple[Float32[np.ndarray, "256"], Float32[np.ndarray, "256"]]:
    """Return for each stored reach what the pixel loses to its neighbour, and what it gains of it."""
    code = np.arange(256)
    distance, slope = 1.0 - (code // 4 - 0.5) / 63.0, (code % 4 + 0.5) / 4.0
    lost, gained = _fraction(distance, slope), _fraction(1.0 - distance, slope)
    lost[:4] = gained[:4] = 0.0
    return lost, gained


def _fading(taken: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    """Return by how much more pixels take of both neighbours along an axis, which together cover ``taken`` of them.

    What is thinner than half a pixel lies in the centre of some pixels and not in that of others: a line of dots. It
    goes before they can be distinguished.
    """
    left = np.clip(1.0 - taken, 0.0, 0.5)
    return np.where(taken > 0.5, (1.0 - left * _rising(left)) / np.maximum(taken, 0.5), 1.0)


def _rising(width: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    """Return how much of a strip of a width (px) is shown: none of the thinnest, all from half a pixel on."""
    rise = np.clip((width - _THINNEST) / (0.5 - _THINNEST), 0.0, 1.0)
    return rise * rise * (3.0 - 2.0 * rise)


def _distances() -> Float32[np.ndarray, "256"]:
    """Return how far the border of each stored reach lies from the centre of its pixel (px)."""
    return (1.0 - (np.arange(256) // 4 - 0.5) / 63.0).astype(np.float32)


_DISTANCE = _distances()
_LINEAR, _SHOWN = _decode(), _encode()
_LOST, _GAINED = _fractions()


class EdgeSmoother:
    """Smooths images of one size; holds memory that would else be requested, and cleared, with every image.

    Args:
        size: Width and height in pixels.
    """

    def __init__(self, size: tuple[int, int]) -> None:
        self._size = size
        self._flag = np.empty(size[0] * size[1], bool)
        self._row = np.empty(size[0] * size[1], np.int32)
        self._border = np.empty(size[0] * size[1], np.float32)

    def smooth(
        self,
        rgba: UInt8[np.ndarray, "h w 4"],
        reach: UInt8[np.ndarray, "h w 4"],
        stored_depth: Float32[np.ndarray, "h w"],
    ) -> None:
        """Blend the pixels of ``rgba`` that a border crosses with what lies beyond it, in place; alpha is lost.

        Areas add up light, so the blending is done in linear values.

        Args:
            rgba: Displayed colours.
            reach: Where a pixel's face ends on the left, right, top and bottom, as ``gbuffer.frag`` stores it.
            stored_depth: A number that is larger for what is nearer.
        """
        width, height = self._size
        words, nearness = reach.view(np.uint32).reshape(-1), stored_depth.reshape(-1)
        near_edge = np.flatnonzero(np.not_equal(words, 0, out=self._flag))
        bytes_of = _bytes(words[near_edge])
        row, column = np.divmod(near_edge, width)
        taking, giving, fractions, strips = [], [], [], []
        for step, forth, back, room_forth, room_back in (
            (1, _RIGHT, _LEFT, column < width - 1, column > 0),
            (width, _BOTTOM, _TOP, row < height - 1, row > 0),
        ):
            forward = near_edge[(bytes_of[:, forth] > 0) & room_forth]
            backward = near_edge[(bytes_of[:, back] > 0) & room_back] - step
            known = _bytes(words[backward])[:, forth] > 0
            first = np.concatenate([forward, backward[~known]])
            mine, theirs = _bytes(words[first])[:, forth], _bytes(words[first + step])[:, back]
            # The nearer face draws the border, unless it goes on there: then the other one stands on it.
            by_mine = (mine > 0) & ((nearness[first] >= nearness[first + step]) | (theirs == 0))
            taking += [first, first + step]
            giving += [first + step, first]
            fractions += [
                np.where(by_mine, _LOST[mine], _GAINED[theirs]),
                np.where(by_mine, _GAINED[mine], _LOST[theirs]),
            ]
            after = np.where(by_mine, _DISTANCE[mine], 1.0 - _DISTANCE[theirs])
            strips.append(self._strips(first, after, step))
        ends = len(taking[0]) + len(taking[1]), sum(map(len, taking))
        colors = rgba.view(np.uint32).reshape(-1)
        for strip in strips:
            more = joined(strip, self._size, nearness, colors, self._row)
            taking.append(more.taking)
            giving.append(more.giving)
            fractions.append(more.fraction * _rising(more.width))
        self._blend(rgba, np.concatenate(taking), np.concatenate(giving), np.concatenate(fractions), ends)

    def _strips(self, first: Int[np.ndarray, " n"], after: Float32[np.ndarray, " n"], step: int) -> Strips:
        """Return the pixels that two borders cross; those after ``first`` lie ``after`` (px) from its centres."""
        self._border[:] = 0.0
        self._border[first] = np.maximum(after, _LEAST)
        ending = self._border[first + step]
        width = ending + 1.0 - after
        crossed = np.flatnonzero((ending > 0.0) & (width < 1.0) & (width > _THINNEST))
        before, ending = 1.0 - after[crossed], ending[crossed]
        return Strips(first[crossed] + step, ending + before, (ending - before) / 2.0, step)

    def _blend(
        self,
        rgba: np.ndarray,
        taking: np.ndarray,
        giving: np.ndarray,
        fraction: np.ndarray,
        ends: tuple[int, int],
    ) -> None:
        """Replace in each pixel of ``taking`` a ``fraction`` by the colour of ``giving``; pixels may take twice.

        The first pairs lie beside each other, those from one end to the other below each other, the rest in gaps.
        """
        colors = rgba.view(np.uint32).reshape(-1)
        seen = np.flatnonzero((fraction > _LEAST) & (colors[taking] != colors[giving]))
        beside, below = (int(number) for number in np.searchsorted(seen, ends))
        taking, fraction, given = taking[seen], fraction[seen], _bytes(colors[giving[seen]])
        self._flag[:] = False
        self._flag[taking] = True
        pixels = np.flatnonzero(self._flag)
        self._row[pixels] = np.arange(len(pixels))
        row = self._row[taking]
        for pairs in (slice(None, beside), slice(beside, below)):
            fraction[pairs] *= _fading(np.bincount(row[pairs], fraction[pairs], len(pixels)))[row[pairs]]
        total = np.bincount(row, fraction, len(pixels))
        scale = 1.0 / np.maximum(total, 1.0)  # a sliver between two borders may be covered from both sides
        weight, kept = fraction * scale[row], 1.0 - total * scale
        result = _bytes(colors[pixels])
        for channel in range(3):
            mixed = _LINEAR[result[:, channel]] * kept
            mixed += np.bincount(row, _LINEAR[given[:, channel]] * weight, len(pixels))
            result[:, channel] = _SHOWN[(mixed * _STEPS + 0.5).astype(np.intp)]
        colors[pixels] = result.view(np.uint32)[:, 0]


def _bytes(words: UInt32[np.ndarray, " n"]) -> UInt8[np.ndarray, "n 4"]:
    """Return the four bytes of each word: four channels picked from an image as words are picked much faster."""
    return words.view(np.uint8).reshape(-1, 4)
