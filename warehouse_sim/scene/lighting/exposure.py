"""Exposure values and the factor from luminance to image values.

Saturation-based, after Lagarde & de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", section 5.1: the
luminance that just saturates the sensor is L_max = 78 / (S q) 2^EV = 1.2 * 2^EV at ISO S = 100 with q = 0.65.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.ranges import Range, ranged

_SATURATION = 1.2
_METER = 12.5
"""Calibration constant K of reflected-light meters (cd s / (m^2 ISO)), as most makers set it; ISO 2720."""
_ISO = 100.0
_GAMMA = 2.2
_DARKEST = 1e-9
"""Luminance (cd/m^2) that a view without any light is metered as."""


@dataclass(frozen=True)
@ranged
class ExposureConfig:
    """How the camera is exposed."""

    mode: Literal["metered", "fixed"] = "metered"
    """By what it looks at, again for each view, or always the same."""
    ev: Annotated[float, Range(-6, 18)] | None = None
    """Exposure value at ISO 100 of the fixed mode, -6 to 18."""
    compensation: Annotated[float, Range(-5, 5, "stops")] = 0.0
    """Stops by which metered images are brighter than the meter says, -5 to 5."""
    min_ev: Annotated[float, Range(-6, 18)] = -6.0
    """Least exposure value that the metered mode reaches, -6 to 18: longest time and highest gain of the camera."""

    def __post_init__(self) -> None:
        if (self.mode == "fixed") != (self.ev is not None):
            raise ValueError(f"ev belongs to the fixed mode and to no other, found mode {self.mode} and ev {self.ev}")

    def ev_for(self, luminance: Float[np.ndarray, " n"], weights: Float[np.ndarray, " n"]) -> float:
        """Return the exposure value for a view.

        Args:
            luminance: Luminances in it (cd/m^2).
            weights: How much each counts for the meter.
        """
        if self.ev is not None:
            return self.ev
        return max(metered_ev(luminance, weights) - self.compensation, self.min_ev)


def metered_ev(luminance: Float[np.ndarray, " n"], weights: Float[np.ndarray, " n"]) -> float:
    """Return EV = log2(L S / K) of the mean luminance L (cd/m^2) at ISO S = 100.

    The mean is that of values encoded with a gamma of 2.2, since cameras meter their image: a bright door pulls the
    exposure less than it would pull the mean of the luminance itself, and black corners less than a log-average.
    """
    mean = float(np.average(luminance ** (1.0 / _GAMMA), weights=weights)) ** _GAMMA
    return float(np.log2(max(mean, _DARKEST) * _ISO / _METER))


def exposure_of_ev(ev: float) -> float:
    """Return the linear image value of 1 cd/m^2 at an exposure value: 1 / L_max."""
    return float(1.0 / (_SATURATION * 2.0**ev))


def ev_of_exposure(exposure: float) -> float:
    """Return the exposure value at ISO 100 of a linear image value of 1 cd/m^2."""
    return float(-np.log2(_SATURATION * exposure))
