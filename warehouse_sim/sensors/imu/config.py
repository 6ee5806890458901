"""Settings of an inertial measurement unit."""

from dataclasses import dataclass
from typing import Annotated

from warehouse_sim.ranges import Range, ranged


@dataclass(frozen=True)
@ranged
class ImuConfig:
    """Bias and noise of a consumer MEMS unit; the defaults are those of the BMI055 in Intel's D435i depth camera.

    Source: Bosch Sensortec, BMI055 data sheet BST-BMI055-DS000-08 (2014), typical values, unverified: its table was
    not at hand; rates of the D435i.
    """

    accel_noise_ug: Annotated[float, Range(0, 100_000, "ug/sqrt(Hz)")] = 150.0
    """Noise density of the accelerometer (1e-6 g/sqrt(Hz)), 0-100,000."""
    accel_bandwidth: Annotated[float, Range(0.1, 10_000, "Hz")] = 62.5
    """Bandwidth that its readings are filtered to (Hz), 0.1-10,000."""
    accel_bias_mg: Annotated[float, Range(0, 1000, "mg")] = 70.0
    """Largest offset of an axis of the accelerometer (1e-3 g), 0-1,000; drawn evenly, once a scene."""
    gyro_noise_deg: Annotated[float, Range(0, 100, "deg/s/sqrt(Hz)")] = 0.014
    """Noise density of the gyroscope (deg/s/sqrt(Hz)), 0-100."""
    gyro_bandwidth: Annotated[float, Range(0.1, 10_000, "Hz")] = 47.0
    """Bandwidth that its readings are filtered to (Hz), 0.1-10,000."""
    gyro_bias_deg: Annotated[float, Range(0, 100, "deg/s")] = 1.0
    """Largest offset of an axis of the gyroscope (deg/s), 0-100; drawn evenly, once a scene."""
