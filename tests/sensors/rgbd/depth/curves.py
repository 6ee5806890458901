"""What was published of depth cameras: curves of sigma and fill by preset, each with its source.

A curve is a figure of somebody else. What a model was given as its own parameter is said to be so (``own``): that it
comes out again shows that the model keeps it, not that the camera has it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

Quantity = Literal["sigma", "fill", "bound"]
"""Standard deviation of depth (m); fraction of pixels read; upper bound of sigma (m)."""


@dataclass(frozen=True)
class Curve:
    """A published figure as a function of range and angle on one material."""

    preset: str
    """Whose."""
    quantity: Quantity
    """What is compared; of a bound only what exceeds it counts."""
    source: str
    """Paper or data sheet."""
    value: Callable[[float, float], float]
    """From z (m) and the angle of incidence (rad) to the figure."""
    distances: tuple[float, ...]
    """Where it was measured (m)."""
    angles_deg: tuple[float, ...] = (0.0,)
    """Angles of incidence at which it was measured."""
    material: str = "white"
    """On what; a name of ``depth_planes.MATERIALS``."""
    own: bool = False
    """Whether the model has the formula itself."""


def ahn_2019(z: float, angle: float) -> float:
    """Return the sigma (m) of a D435 by its fit over the distance z (m), straight on."""
    return 0.001063 + 0.0007278 * z + 0.003949 * z * z


def triangulated(subpixel_px: float, focal_px: float, baseline: float) -> Callable[[float, float], float]:
    """Return z^2 dd / (f b)."""
    return lambda z, angle: z * z * subpixel_px / (focal_px * baseline)


def nguyen_2012(z: float, angle: float) -> float:
    """Return the sigma (m) of a Kinect v1."""
    lean = angle / (np.pi / 2 - angle)
    return 0.0012 + 0.0019 * (z - 0.4) ** 2 + 0.0001 / np.sqrt(z) * lean**2


def cai_2024(z: float, angle: float) -> float:
    """Return the sigma (m) of a Flexx2 in its mode 5."""
    lean = angle / (np.pi / 2 - angle)
    return 0.002362 - 0.001041 * z + 0.000753 * z * z + 0.000185 * z**2.7 * lean**2


def tolgyessy_2021(z: float, angle: float) -> float:
    """Return the sigma (m) of an Azure Kinect in its narrow, unbinned mode."""
    return float(np.interp(z, (0.8, 1.5, 3.0), (0.0006132, 0.0008873, 0.0017824)))


def recorded_faces(z: float, angle: float) -> float:
    """Return the sigma (m) of recorded pallet faces: that over time, and a pattern of 0.7 % of z that stays."""
    over_time = float(np.interp(z, (0.5, 1.0, 1.5, 2.0), (0.0052, 0.011, 0.0178, 0.0246)))
    return float(np.hypot(over_time, 0.007 * z))


def fraction_of_range(fraction: float) -> Callable[[float, float], float]:
    """Return a fraction of z."""
    return lambda z, angle: fraction * z


def constant(value: float) -> Callable[[float, float], float]:
    """Return one value everywhere."""
    return lambda z, angle: value


STEREO_CURVES = (
    Curve(
        "d435", "sigma", "Ahn et al. 2019, Analysis and noise modeling of the Intel RealSense D435 for mobile robots",
        ahn_2019, (0.6, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0),
    ),
    Curve(
        "d435", "sigma", "Rustler et al. 2025, arXiv 2501.07421: 0.75 % at 2 m, second-hand",
        fraction_of_range(0.0075), (2.0,),
    ),
    Curve(
        "d455", "sigma", "Grunnet-Jepsen et al., Tuning depth cameras for best performance: z^2 0.08 px / (f b)",
        triangulated(0.08, 447.0, 0.095), (0.8, 1.0, 2.0, 3.0, 4.0),
    ),
    Curve(
        "d435", "bound", "Intel, D400 data sheet 337029-009, table 4-9: at most 2 % at 2 m",
        fraction_of_range(0.02), (0.5, 1.0, 2.0),
    ),
    Curve(
        "d455", "bound", "Intel, D400 data sheet 337029-009, table 4-9: at most 2 % at 4 m",
        fraction_of_range(0.02), (1.0, 2.0, 4.0),
    ),
    Curve(
        "d435", "fill", "Intel, D400 data sheet 337029-009, table 4-9: at least 99 % up to 2 m",
        constant(1.0), (0.5, 1.0, 2.0),
    ),
    Curve(
        "d455", "fill", "Intel, D400 data sheet 337029-009, table 4-9: at least 99 % up to 4 m",
        constant(1.0), (1.0, 2.0, 4.0),
    ),
)  # fmt: skip
"""Active stereo."""

STRUCTURED_CURVES = (
    Curve(
        "kinect_v1", "sigma", "Nguyen, Izadi & Lovell 2012", nguyen_2012,
        (0.9, 1.2, 1.8, 2.4, 3.0), (0.0, 30.0, 60.0), own=True,
    ),
    Curve("kinect_v1", "fill", "Nguyen, Izadi & Lovell 2012: read up to 3 m and 60 deg", constant(1.0),
          (0.9, 1.2, 1.8, 2.4, 3.0), (0.0, 30.0, 60.0)),
)  # fmt: skip
"""Structured light."""

TIME_OF_FLIGHT_CURVES = (
    Curve(
        "flexx2", "sigma", "Cai et al. 2024, arXiv 2412.15040", cai_2024,
        (0.5, 1.0, 1.5, 2.0), (0.0, 30.0, 60.0), own=True,
    ),
    Curve(
        "azure_kinect", "sigma", "Tölgyessy et al. 2021, Evaluation of the Azure Kinect, second-hand", tolgyessy_2021,
        (0.8, 1.5, 3.0),
    ),
    Curve(
        "azure_kinect", "bound", "Microsoft, Azure Kinect hardware specification: at most 17 mm", constant(0.017),
        (0.8, 1.5, 3.0, 3.8),
    ),
    Curve(
        "tof_industrial", "sigma", "recorded pallet faces, medians over surfaces of 0.3 or so", recorded_faces,
        (0.5, 1.0, 1.5, 2.0), material="kraft", own=True,
    ),
)  # fmt: skip
"""Time of flight."""

CURVES = (*STEREO_CURVES, *STRUCTURED_CURVES, *TIME_OF_FLIGHT_CURVES)
