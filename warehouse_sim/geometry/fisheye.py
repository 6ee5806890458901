"""Fisheye lenses after Kannala and Brandt, with OpenCV's names, and the inverse; a lens is either of the two kinds."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.ranges import Range, check_ranges

WIDEST_DEG = 76.0
"""Largest angle to the axis that is believed: an image is drawn as a plane first, which grows as the tangent.

An image of 16 : 9 and 130 deg across has its corners at 75 deg.
"""
_LEAST_SLOPE = 0.25
"""Growth of the image with the angle, 1 on the axis, at which a lens is no longer believed."""
_NOTHING = 1e-100
_TABLE = 4096
_MOST_STEPS = 50
_TOLERANCE = 1e-14


@dataclass(frozen=True)
class Fisheye:
    """Coefficients of Kannala and Brandt 2006, "A generic camera model ...", as OpenCV's ``fisheye`` gives them.

    A point at the angle t to the axis is shown in its own direction at t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8); with
    all of them 0 the lens is equidistant. The formula is believed as far as ``radius``; beyond, the map is continued in
    proportion to the tangent, as that of ``Distortion`` is.
    """

    k1: Annotated[float, Range(-10, 10)] = 0.0
    """Of t^3, -10 to 10."""
    k2: Annotated[float, Range(-10, 10)] = 0.0
    """Of t^5, -10 to 10."""
    k3: Annotated[float, Range(-10, 10)] = 0.0
    """Of t^7, -10 to 10."""
    k4: Annotated[float, Range(-10, 10)] = 0.0
    """Of t^9, -10 to 10."""

    def __post_init__(self) -> None:
        check_ranges(self)  # a ValueError, as all of geometry raises

    @property
    def coefficients(self) -> tuple[float, float, float, float]:
        """OpenCV's ``D`` of its ``fisheye`` module: k1, k2, k3, k4."""
        return self.k1, self.k2, self.k3, self.k4

    @cached_property
    def radius(self) -> float:
        """Tangent of the largest angle to the axis at which the formula holds."""
        return math.tan(self._limit)

    def apply(self, xy: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 2"]:
        """Return where the image shows points of the plane z = 1."""
        r = np.hypot(xy[..., 0], xy[..., 1])
        inside = np.minimum(r, self.radius)
        shown = self._shown(np.arctan(inside))
        return np.asarray(xy * np.divide(shown, inside, out=np.ones_like(r), where=inside > 0.0)[..., None])

    def remove(self, distorted: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 2"]:
        """Return the points of the plane z = 1 that the image shows at ``distorted``: the inverse of ``apply``."""
        distorted = np.asarray(distorted, float)
        length = np.hypot(distorted[..., 0], distorted[..., 1])
        inside = np.minimum(length, self._shown(np.array(self._limit)))
        found = np.tan(self._angles(inside.ravel()).reshape(inside.shape))
        return np.asarray(distorted * np.divide(found, inside, out=np.ones_like(length), where=inside > 0.0)[..., None])

    def jacobian(self, xy: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 2 2"]:
        """Return the derivatives of the formula, (x', y') by (x, y); only for points within ``radius``."""
        r = np.hypot(xy[..., 0], xy[..., 1])
        angle, far = np.arctan(r), r > 1e-6
        factor = np.divide(self._shown(angle), r, out=np.ones_like(r), where=far)
        # d (g(r) x) / d x = g + g' / r x x^T; on the axis g' / r goes to 2 (k1 - 1 / 3).
        change = self._slope(angle) / (1.0 + r * r) - factor
        change = np.divide(change, r * r, out=np.full_like(r, 2.0 * (self.k1 - 1.0 / 3.0)), where=far)
        outer = xy[..., :, None] * xy[..., None, :]
        return np.asarray(factor[..., None, None] * np.eye(2) + change[..., None, None] * outer)

    def covers(self, distorted: Float[np.ndarray, "n 2"]) -> bool:
        """Return whether the formula holds, one to one, for all that the image shows at ``distorted``."""
        farthest = np.hypot(distorted[:, 0], distorted[:, 1]).max(initial=0.0)
        return bool(farthest <= self._shown(np.array(self._limit)))

    @cached_property
    def _limit(self) -> float:
        """The largest angle to the axis at which the formula holds (rad)."""
        slope = np.array([9.0 * self.k4, 7.0 * self.k3, 5.0 * self.k2, 3.0 * self.k1, 1.0 - _LEAST_SLOPE])
        roots = np.roots(np.where(np.abs(slope) < _NOTHING, 0.0, slope))
        squares = [root.real for root in np.atleast_1d(roots) if abs(root.imag) < 1e-12 and root.real > 0]
        return min(math.radians(WIDEST_DEG), math.sqrt(min(squares, default=math.inf)))

    def _shown(self, angle: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
        s = angle * angle
        return np.asarray(angle * (1.0 + s * (self.k1 + s * (self.k2 + s * (self.k3 + s * self.k4)))))

    def _slope(self, angle: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
        s = angle * angle
        return np.asarray(1.0 + s * (3.0 * self.k1 + s * (5.0 * self.k2 + s * (7.0 * self.k3 + s * 9.0 * self.k4))))

    def _angles(self, shown: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
        """Return the angles that are shown at these distances from the axis, by Newton's method from a table."""
        table = np.linspace(0.0, self._limit, _TABLE)
        angle = np.interp(shown, self._shown(table), table)
        for _ in range(_MOST_STEPS):
            error = self._shown(angle) - shown
            if np.abs(error).max(initial=0.0) < _TOLERANCE:
                break
            angle = np.minimum(angle - error / self._slope(angle), self._limit)
        return np.asarray(angle)


Lens = Distortion | Fisheye
"""What a lens does to an image."""


def lens_of(coefficients: Sequence[float]) -> Lens:
    """Return the lens of OpenCV's coefficients: five of Brown and Conrady, four of a fisheye.

    Raises:
        ValueError: Another number of them, or one out of range.
    """
    if len(coefficients) not in (4, 5):
        raise ValueError(f"a lens has 5 coefficients, a fisheye 4; found {len(coefficients)}")
    return Fisheye(*coefficients) if len(coefficients) == 4 else Distortion(*coefficients)


def same_lens(one: Lens | None, other: Lens | None) -> bool:
    """Return whether two lenses are alike to nine digits; none is a ``Distortion`` by nothing."""
    one, other = one or Distortion(), other or Distortion()
    alike = type(one) is type(other)
    return alike and bool(np.allclose(one.coefficients, other.coefficients, rtol=1e-9, atol=1e-12))
