"""The lasers of a LiDAR: where they point and start, when each fires within a cycle, and tables of real units."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

BEAM_ORIGIN_MM = 15.806
"""From the axis to where the rays start, along the way that the head points."""
ALTITUDE_DEG = """
 20.95  20.67  20.36  20.03  19.73  19.41  19.11  18.76  18.47  18.14  17.82   17.5  17.19  16.86  16.53   16.2
 15.89  15.56  15.23   14.9  14.57  14.23   13.9  13.57  13.25  12.91  12.57  12.22   11.9  11.55   11.2  10.87
 10.54  10.18   9.84   9.51   9.15   8.81   8.47   8.11   7.78   7.43   7.08   6.74   6.39   6.04    5.7   5.34
  4.98   4.64   4.29   3.93   3.58   3.24   2.88   2.53   2.17   1.82   1.47   1.12   0.78   0.41   0.07  -0.28
 -0.64  -0.99  -1.35   -1.7  -2.07   -2.4  -2.75  -3.11  -3.46  -3.81  -4.15   -4.5  -4.86  -5.22  -5.57   -5.9
 -6.27  -6.61  -6.97   -7.3  -7.67  -8.01  -8.35  -8.69  -9.05  -9.38  -9.71 -10.07 -10.42 -10.76 -11.09 -11.43
-11.78 -12.12 -12.46 -12.78 -13.15 -13.46  -13.8 -14.12 -14.48 -14.79 -15.11 -15.46 -15.79 -16.12 -16.45 -16.76
-17.11 -17.44 -17.74 -18.06 -18.39 -18.72 -19.02 -19.32 -19.67 -19.99 -20.27 -20.57 -20.92 -21.22 -21.54 -21.82
"""
AZIMUTH_DEG = """
  4.21   1.41   -1.4  -4.22   4.22   1.41   -1.4  -4.23   4.21    1.4  -1.42   -4.2   4.22   1.41   -1.4  -4.23
  4.21   1.41  -1.41  -4.21   4.22    1.4  -1.41   -4.2   4.22   1.42   -1.4   -4.2   4.22   1.41  -1.42  -4.21
  4.22   1.41   -1.4  -4.21    4.2    1.4   -1.4  -4.22   4.21   1.41  -1.41  -4.21   4.22   1.41   -1.4  -4.21
  4.21   1.41   -1.4  -4.21    4.2   1.41   -1.4  -4.21    4.2    1.4  -1.41  -4.21   4.22    1.4   -1.4  -4.21
  4.22   1.42   -1.4   -4.2    4.2   1.42   -1.4  -4.22   4.22   1.41   -1.4   -4.2   4.23   1.41   -1.4   -4.2
  4.21   1.41   -1.4  -4.21   4.21   1.41   -1.4  -4.21   4.22   1.41  -1.39  -4.21   4.23   1.41  -1.39  -4.22
  4.23    1.4   -1.4   -4.2   4.21   1.41  -1.41   -4.2   4.22   1.42  -1.39  -4.22   4.24   1.41  -1.41  -4.22
  4.23   1.41  -1.39  -4.21   4.23   1.41  -1.39   -4.2   4.23    1.4  -1.39   -4.2   4.22   1.42  -1.39   -4.2
"""


HDL64E_S3 = """
      -7.230 -4.382 215.7 26 |  -6.849 -2.253 215.2 -26 |     0.204 3.441 206.3 26 |    0.591 5.683 205.8 -26
      -6.560 -0.055 214.8 26 |   -6.190 2.191 214.4 -26 |   -8.563 -0.876 217.4 26 |   -8.219 1.390 217.0 -26
       -5.889 4.214 214.0 26 |   -5.483 6.485 213.5 -26 |    -7.943 3.412 216.6 26 |   -7.552 5.676 216.1 -26
      -3.119 -4.340 210.5 26 |  -2.792 -2.123 210.1 -26 |   -5.135 -5.133 213.0 26 |  -4.809 -2.907 212.6 -26
      -2.488 -0.107 209.7 26 |   -2.091 2.147 209.2 -26 |   -4.530 -0.871 212.3 26 |   -4.157 1.371 211.8 -26
       -1.810 4.162 208.8 26 |   -1.459 6.385 208.4 -26 |    -3.819 3.405 211.4 26 |   -3.469 5.613 210.9 -26
       0.895 -4.388 205.4 26 |   1.293 -2.172 205.0 -26 |   -1.143 -5.184 208.0 26 |  -0.756 -2.940 207.5 -26
       1.562 -0.110 204.6 26 |    1.960 2.109 204.1 -26 |   -0.452 -0.890 207.1 26 |   -0.089 1.334 206.7 -26
     -22.358 -7.326 159.7 26 | -21.976 -3.812 159.2 -26 |   -11.295 5.073 146.6 26 |  -10.754 8.335 146.0 -26
     -21.491 -0.291 158.6 26 |  -21.064 3.110 158.1 -26 |  -24.555 -1.613 162.5 26 |  -24.147 1.818 162.0 -26
      -20.429 6.538 157.3 26 |  -19.892 9.944 156.6 -26 |   -23.549 5.480 161.2 26 |  -22.966 8.903 160.5 -26
     -16.274 -7.112 152.3 26 | -15.906 -3.675 151.9 -26 |  -19.247 -8.521 155.8 26 | -18.923 -4.989 155.5 -26
     -15.385 -0.390 151.2 26 |  -14.927 3.004 150.7 -26 |  -18.429 -1.626 154.9 26 |  -17.964 1.824 154.3 -26
      -14.291 6.277 150.0 26 |  -13.806 9.670 149.4 -26 |   -17.368 5.178 153.6 26 |  -16.801 8.521 152.9 -26
     -10.176 -6.933 145.3 26 |  -9.744 -3.685 144.8 -26 |  -13.163 -8.300 148.7 26 | -12.830 -4.884 148.3 -26
      -9.300 -0.342 144.3 26 |   -8.775 2.899 143.7 -26 |  -12.294 -1.572 147.7 26 |  -11.913 1.664 147.3 -26
"""

HDL64E_S21 = """
      -8.769 -7.156 195.5 26 |  -8.356 -3.967 196.0 -26 |     2.486 4.721 209.7 26 |    2.977 7.896 210.3 -26
      -7.782 -0.642 196.7 26 |   -7.264 2.624 197.4 -26 |  -10.861 -1.813 192.8 26 |  -10.363 1.341 193.4 -26
       -6.861 5.767 197.9 26 |   -6.259 9.165 198.7 -26 |    -9.818 4.763 194.1 26 |   -9.340 7.943 194.7 -26
      -2.593 -7.195 203.3 26 |  -2.056 -3.848 204.0 -26 |   -5.669 -8.353 199.4 26 |  -5.193 -5.095 200.0 -26
      -1.588 -0.745 204.6 26 |   -1.154 2.634 205.1 -26 |   -4.704 -1.855 200.7 26 |   -4.169 1.393 201.3 -26
       -0.569 5.746 205.9 26 |   -0.218 9.092 206.3 -26 |    -3.714 4.609 201.9 26 |   -3.189 7.946 202.6 -26
       3.502 -7.165 211.0 26 |   4.004 -3.905 211.6 -26 |    0.509 -8.326 207.2 26 |   0.977 -5.102 207.8 -26
       4.493 -0.691 212.2 26 |    4.970 2.515 212.8 -26 |    1.445 -1.895 208.4 26 |    1.972 1.463 209.0 -26
     -22.727 -7.626 108.1 26 | -22.358 -4.149 108.6 -26 |   -11.520 4.751 121.5 26 |  -10.946 8.025 122.1 -26
     -21.885 -0.688 109.2 26 |  -21.308 2.769 109.9 -26 |  -24.845 -2.053 105.4 26 |  -24.419 1.540 105.9 -26
      -20.859 6.167 110.5 26 |  -20.119 9.622 111.4 -26 |   -23.854 4.934 106.7 26 |  -23.184 8.608 107.5 -26
     -16.554 -7.448 115.7 26 | -16.112 -4.016 116.2 -26 |  -19.570 -8.788 112.1 26 | -19.185 -5.316 112.5 -26
     -15.689 -0.688 116.7 26 |  -15.178 2.720 117.3 -26 |  -18.724 -1.936 113.1 26 |  -18.218 1.452 113.7 -26
      -14.598 6.006 118.0 26 |  -14.081 9.346 118.6 -26 |   -17.762 4.804 114.2 26 |  -17.112 8.236 115.0 -26
     -10.539 -7.301 122.6 26 |  -9.994 -3.927 123.2 -26 |  -13.407 -8.579 119.3 26 | -12.974 -5.141 119.8 -26
      -9.619 -0.673 123.6 26 |   -9.072 2.572 124.2 -26 |  -12.417 -1.950 120.5 26 |  -12.070 1.424 120.9 -26
"""


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
