"""How a luminaire spreads its light: intensity by direction, measured and not a formula."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Float32

PLANES, ANGLES = 144, 181
"""Half planes through the axis (every 2.5 deg), and angles from the axis in each (every degree, 0-180)."""


@dataclass(frozen=True, eq=False)
class IntensityDistribution:
    """Luminous intensity around a luminaire, on a grid of directions that all who draw or measure it look up."""

    name: str
    """Of the file that it comes from."""
    peak: float
    """Greatest intensity of the luminaire as measured (cd)."""
    fraction: Float32[np.ndarray, "144 181"]
    """Intensity over the greatest: row by half plane C from the luminaire's length on, column by angle to its axis."""

    @cached_property
    def flux_per_candela(self) -> float:
        """Luminous flux (lm) where the greatest intensity is 1 cd: the exact integral of what lies between the grid."""
        angle = np.deg2rad(np.linspace(0.0, 180.0, ANGLES))
        mean = self.fraction.mean(axis=0, dtype=float)  # of the piecewise linear function around the axis
        low, high, step = angle[:-1], angle[1:], angle[1] - angle[0]
        slope = np.diff(mean) / step
        # Integral of (a + s (t - t0)) sin t over one step.
        whole = mean[:-1] * np.cos(low) - mean[1:] * np.cos(high) + slope * (np.sin(high) - np.sin(low))
        return float(2.0 * np.pi * whole.sum())

    @cached_property
    def widest(self) -> float:
        """Greatest angle (rad) from the axis at which there is a thousandth of the greatest intensity."""
        return float(np.deg2rad(np.flatnonzero(self.fraction.max(axis=0) >= 1e-3).max()))

    @cached_property
    def half_angle(self) -> float:
        """Angle (rad) from the axis beyond which less than half of the greatest mean over all half planes is left."""
        mean = self.fraction.mean(axis=0)
        return float(np.deg2rad(np.flatnonzero(mean >= mean.max() / 2).max()))

    def at(self, directions: Float[np.ndarray, "n 3"], axis: np.ndarray, along: np.ndarray) -> Float[np.ndarray, " n"]:
        """Return the intensity over the greatest in unit ``directions`` away from the luminaire.

        Args:
            directions: In the world.
            axis: Unit vector straight out of the luminaire, where the angle is 0.
            along: Unit vector along its length, across ``axis``, where the half plane is C 0; they go on
                anticlockwise as seen from above a luminaire that shines down (LM-63-2002, "horizontal angles").
        """
        angle = np.degrees(np.arccos(np.clip(directions @ axis, -1.0, 1.0)))
        turned = np.degrees(np.arctan2(directions @ np.cross(along, axis), directions @ along))
        row, column = (turned % 360.0) * (PLANES / 360.0), np.minimum(angle, 179.999)
        i, j = row.astype(int), column.astype(int)
        down, right = row - i, column - j
        i, below = i % PLANES, (i + 1) % PLANES
        fraction = self.fraction
        near = fraction[i, j] * (1.0 - right) + fraction[i, j + 1] * right
        far = fraction[below, j] * (1.0 - right) + fraction[below, j + 1] * right
        mixed: Float[np.ndarray, " n"] = near * (1.0 - down) + far * down
        return mixed
