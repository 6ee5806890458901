"""Where the lasers of a LiDAR point, where their rays start, and when each fires within a cycle."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.sensors.lidar.hdl64e_tables import HDL64E_S3, HDL64E_S21


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
    ``rawdata.cc`` of the package velodyne_pointcloud, which follow the VLP-16 user manual.
    """
    lower = np.arange(-15.0, 0.0, 2.0)
    elevation = np.stack([lower, lower + 16.0], axis=1).ravel()
    up = elevation * (-0.0112 / 15.0)
    return Lasers(np.deg2rad(elevation), np.zeros(16), up, np.zeros(16), np.arange(16) * 2.304e-6)


def os1_128() -> Lasers:
    """Return an OS1-128: +22.5 to -22.5 deg, evenly spaced, all at once (data sheet of the OS1).

    The real one's beams are also staggered in azimuth by a few degrees, of which the data sheet says nothing.
    """
    elevation = np.deg2rad(np.linspace(22.5, -22.5, 128))
    return Lasers(elevation, *(np.zeros(128) for _ in range(4)))


def planar() -> Lasers:
    """Return the one laser of a 2D scanner."""
    return Lasers(*(np.zeros(1) for _ in range(5)))


LASERS: dict[str, Callable[[], Lasers]] = {
    "hdl64e": lambda: hdl64e(HDL64E_S3),
    "hdl64e_s2": lambda: hdl64e(HDL64E_S21),
    "vlp16": vlp16,
    "os1_128": os1_128,
    "safety2d": planar,
}
"""How to make the lasers of each model."""
