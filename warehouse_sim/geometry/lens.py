"""Lens distortion after Brown and Conrady, fisheyes after Kannala and Brandt, as OpenCV names them; their inverses."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from jaxtyping import Float

from warehouse_sim.ranges import Range, check_ranges

_LEAST_SLOPE = 0.25
"""Growth of the image with the true radius or angle, 1 on the axis, at which a lens is no longer believed."""
_NOTHING = 1e-100
"""A coefficient that bends no ray; its roots would overflow."""
_TABLE = 4096
_TOLERANCE = 1e-12
_MOST_STEPS = 50
_CHUNK = 8192
"""Points that are worked on together: few enough to stay in the cache, many enough for numpy."""


@dataclass(frozen=True)
class Distortion:
    """Coefficients of D. C. Brown 1966, "Decentering distortion of lenses", as OpenCV's calibration gives them.

    With (x, y) = (X / Z, Y / Z) and r^2 = x^2 + y^2 the image shows a point at::

        x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
        y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y

    The polynomial was fitted inside the image; outside, many fold far points back into it. It is therefore believed
    as far as ``radius``; beyond, the map is continued in proportion to r, which makes it one to one everywhere.
    """

    k1: Annotated[float, Range(-100, 100)] = 0.0
    """Radial, of r^2, -100 to 100; negative = barrel."""
    k2: Annotated[float, Range(-100, 100)] = 0.0
    """Radial, of r^4, -100 to 100."""
    p1: Annotated[float, Range(-100, 100)] = 0.0
    """Tangential, -100 to 100."""
    p2: Annotated[float, Range(-100, 100)] = 0.0
    """Tangential, -100 to 100."""
    k3: Annotated[float, Range(-100, 100)] = 0.0
    """Radial, of r^6, -100 to 100."""

    def __post_init__(self) -> None:
        check_ranges(self)  # a ValueError, as all of geometry raises

    @property
    def coefficients(self) -> tuple[float, float, float, float, float]:
        """OpenCV's ``distCoeffs``: k1, k2, p1, p2, k3."""
        return self.k1, self.k2, self.p1, self.p2, self.k3

    @cached_property
    def radius(self) -> float:
        """Tangent of the largest angle to the axis at which the formula holds; infinite where it never turns."""
        # d r' / d r = 1 + 3 k1 r^2 + 5 k2 r^4 + 7 k3 r^6
        slope = np.array([7.0 * self.k3, 5.0 * self.k2, 3.0 * self.k1, 1.0 - _LEAST_SLOPE])
        roots = np.roots(np.where(np.abs(slope) < _NOTHING, 0.0, slope))
        squares = [root.real for root in np.atleast_1d(roots) if abs(root.imag) < 1e-12 and root.real > 0]
        return math.sqrt(min(squares)) if squares else math.inf

    def apply(self, xy: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 2"]:
        """Return where the image shows points of the plane z = 1."""
        beyond = np.maximum(np.hypot(xy[..., 0], xy[..., 1]) / self.radius, 1.0)[..., None]
        return self._formula(xy / beyond) * beyond

    def remove(self, distorted: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 2"]:
        """Return the points of the plane z = 1 that the image shows at ``distorted``: the inverse of ``apply``.

        Newton's method from a table of radii, to 1e-12 of the plane.
        """
        flat = np.asarray(distorted, float).reshape(-1, 2)
        beyond = np.maximum(self._fraction_of_rim(flat), 1.0)[:, None]
        inside, found = flat / beyond, np.empty_like(flat)
        for start in range(0, len(flat), _CHUNK):
            found[start : start + _CHUNK] = self._solve(inside[start : start + _CHUNK])
        return (found * beyond).reshape(np.shape(distorted))

    def jacobian(self, xy: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 2 2"]:
        """Return the derivatives of the formula, (x', y') by (x, y); only for points within ``radius``."""
        x, y = xy[..., 0], xy[..., 1]
        s = x * x + y * y
        radial = 1.0 + s * (self.k1 + s * (self.k2 + s * self.k3))
        slope = 2.0 * (self.k1 + s * (2.0 * self.k2 + s * 3.0 * self.k3))
        mixed = slope * x * y + 2.0 * (self.p1 * x + self.p2 * y)
        xx = radial + slope * x * x + 2.0 * self.p1 * y + 6.0 * self.p2 * x
        yy = radial + slope * y * y + 6.0 * self.p1 * y + 2.0 * self.p2 * x
        return np.stack([np.stack([xx, mixed], axis=-1), np.stack([mixed, yy], axis=-1)], axis=-2)

    def covers(self, distorted: Float[np.ndarray, "n 2"]) -> bool:
        """Return whether the formula holds, one to one, for all that the image shows at ``distorted``."""
        if (self._fraction_of_rim(distorted) > 1.0).any():
            return False
        return bool((np.linalg.det(self.jacobian(self._solve(distorted))) > 0).all())

    def _formula(self, xy: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 2"]:
        x, y = xy[..., 0], xy[..., 1]
        s = x * x + y * y
        radial = 1.0 + s * (self.k1 + s * (self.k2 + s * self.k3))
        both = 2.0 * x * y
        shown_x = x * radial + self.p1 * both + self.p2 * (s + 2.0 * x * x)
        shown_y = y * radial + self.p1 * (s + 2.0 * y * y) + self.p2 * both
        return np.stack([shown_x, shown_y], axis=-1)

    @cached_property
    def _rim(self) -> tuple[Float[np.ndarray, " k"], Float[np.ndarray, " k"]]:
        """Directions (rad, ascending) and distances at which the image shows the circle of ``radius``."""
        angle = np.linspace(-np.pi, np.pi, _TABLE, endpoint=False)
        x, y = self._formula(self.radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)).T
        order = np.argsort(np.arctan2(y, x))
        return np.arctan2(y, x)[order], np.hypot(x, y)[order]

    def _fraction_of_rim(self, distorted: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, " n"]:
        """Return the distance from the axis in units of that at which the image shows the circle of ``radius``."""
        if math.isinf(self.radius):
            return np.zeros(len(distorted))
        x, y = distorted.T
        directions, distances = self._rim
        return np.hypot(x, y) / np.interp(np.arctan2(y, x), directions, distances, period=2.0 * np.pi)

    def _solve(self, distorted: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
        """Return what the formula maps to ``distorted``, which the image must show within ``radius``."""
        length = np.hypot(distorted[:, 0], distorted[:, 1])
        # The slope is nowhere below its least value, so that this radius is large enough.
        largest = min(self.radius, max(float(length.max(initial=0.0)), 1e-9) / _LEAST_SLOPE)
        radii = np.linspace(0.0, largest, _TABLE)
        shown = radii * (1.0 + radii**2 * (self.k1 + radii**2 * (self.k2 + radii**2 * self.k3)))
        first = np.interp(length, shown, radii)
        found = distorted * np.divide(first, length, out=np.ones_like(length), where=length > 0)[:, None]
        for _ in range(_MOST_STEPS):
            error = self._formula(found) - distorted
            if np.abs(error).max(initial=0.0) < _TOLERANCE * max(1.0, float(length.max(initial=0.0))):
                break
            (xx, xy), (yx, yy) = np.moveaxis(self.jacobian(found), (-2, -1), (0, 1))
            step_x, step_y = yy * error[:, 0] - xy * error[:, 1], xx * error[:, 1] - yx * error[:, 0]
            found = found - np.stack([step_x, step_y], axis=-1) / (xx * yy - xy * yx)[:, None]
        return found


WIDEST_DEG = 76.0
"""Largest angle to the axis that is believed: an image is drawn as a plane first, which grows as the tangent.

An image of 16 : 9 and 130 deg across has its corners at 75 deg.
"""
_FISHEYE_TOLERANCE = 1e-14


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
            if np.abs(error).max(initial=0.0) < _FISHEYE_TOLERANCE:
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
