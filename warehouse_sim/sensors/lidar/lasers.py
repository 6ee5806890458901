"""Where the lasers of a LiDAR point, where their rays start, and when each fires within a cycle."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.sensors.lidar.hdl64e_tables import HDL64E_S3, HDL64E_S21
from warehouse_sim.sensors.lidar.os1_table import ALTITUDE_DEG, AZIMUTH_DEG, BEAM_ORIGIN_MM


@dataclass(frozen=True, eq=False)
class Lasers:
    """All lasers in the order in which they fire."""

    elevation: Float[np.ndarray, " k"]
    """Above the horizon (rad)."""
    azimuth: Float[np.ndarray, " k"]
    """To the left of where the head points (rad)."""
    up: Float[np.ndarray, " k"]
    """Where the ray starts, perpendicular to it and upwards (m)."""
    left: Float[np.ndarray, " k"]
    """Where the ray starts, to the left (m)."""
    delay: Float[np.ndarray, " k"]
    """Since the firing cycle began (s)."""
    ahead: float = 0.0
    """Where all rays start, from the axis along the way that the head points (m)."""
    turns_between: bool = False
    """Whether the head's turn between the beginning of a cycle and a pulse adds to ``azimuth``."""

    def rings(self) -> Int[np.ndarray, " k"]:
        """Return each laser's number counted from the topmost, 0."""
        return np.argsort(np.argsort(-self.elevation, kind="stable"), kind="stable")


def hdl64e(table: str) -> Lasers:
    """Return an HDL-64E with the calibration ``table``.

    It fires 64 times in 48 us, 1.333 million times a second; that the pulses are evenly spaced is an assumption.
    """
    elevation, azimuth, up_mm, left_mm = np.array(table.replace("|", " ").split(), float).reshape(-1, 4).T
    delay = np.arange(len(elevation)) * (48e-6 / len(elevation))
    return Lasers(np.deg2rad(elevation), np.deg2rad(azimuth), up_mm / 1000.0, left_mm / 1000.0, delay)


def vlp16() -> Lasers:
    """Return a VLP-16: -15 to 15 deg in steps of 2, lower and upper lasers in turns, 2.304 us apart.

    Order, offsets (11.2 mm at the outermost) and times are those of ``VLP16db.yaml`` and of the timing table in
    ``rawdata.cc`` of the package velodyne_pointcloud, which follow the VLP-16 user manual. As there, each laser looks
    where the head has turned to when it fires.
    """
    lower = np.arange(-15.0, 0.0, 2.0)
    elevation = np.stack([lower, lower + 16.0], axis=1).ravel()
    up = elevation * (-0.0112 / 15.0)
    return Lasers(np.deg2rad(elevation), np.zeros(16), up, np.zeros(16), np.arange(16) * 2.304e-6, turns_between=True)


def os1_128() -> Lasers:
    """Return an OS1-128 as one unit was measured, all lasers at once.

    Ouster counts azimuths clockwise, as the head turns: its positive ones look to the right (sensor documentation,
    "Lidar Range to XYZ": the encoder's angle is 2 pi less the fraction of the turn, less the beam's azimuth).
    """
    elevation, right = (np.deg2rad(np.array(table.split(), float)) for table in (ALTITUDE_DEG, AZIMUTH_DEG))
    nothing = np.zeros(128)
    return Lasers(elevation, -right, nothing, nothing, nothing, ahead=BEAM_ORIGIN_MM / 1000.0)


def planar() -> Lasers:
    """Return the one laser of a 2D scanner."""
    nothing = np.zeros(1)
    return Lasers(nothing, nothing, nothing, nothing, nothing)


LASERS: dict[str, Callable[[], Lasers]] = {
    "hdl64e": lambda: hdl64e(HDL64E_S3),
    "hdl64e_s2": lambda: hdl64e(HDL64E_S21),
    "vlp16": vlp16,
    "os1_128": os1_128,
    "safety2d": planar,
}
"""How to make the lasers of each model."""
