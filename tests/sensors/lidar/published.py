"""What manuals, data sheets, calibration files and recordings say of LiDARs: numbers as they stand there."""

from dataclasses import dataclass

from warehouse_sim.sensors.lidar.config import Model


@dataclass(frozen=True)
class Published:
    """What one LiDAR is held against."""

    spin: int
    """1 = counter-clockwise seen from above, -1 = clockwise."""
    lasers: int
    elevation_deg: tuple[tuple[int, float], ...]
    """Ring, counted from the topmost, and its elevation."""
    left_deg: tuple[tuple[int, float], ...]
    """Ring and azimuth to the left of the first of them, in the same firing cycle."""
    points_a_second: float
    noise_mm: float
    """From pulse to pulse, one sigma."""
    bias_mm: float | None
    """From laser to laser, one sigma; None = no source."""
    source: str


# Laser ids 29, 25, 38, 36 of the file: the rings are their places among all elevations.
_XIESC = {29: 0.03421014630846329, 25: 0.022567997346205196, 38: -0.4285668719175616, 36: -0.3750836655445631}
_XIESC_LEFT = {29: 0.03681404490741569, 25: -0.0379098725675606, 38: -0.028143856558087547, 36: -0.005071588212420635}
_DEGREE = 57.29577951308232
_XIESC_RINGS = {29: 0, 25: 2, 38: 63, 36: 57}
_OUSTER = (20.95, 20.67, 20.36, 20.03, 19.73, 19.41, 19.11, 18.76)
_OUSTER_RIGHT = (4.21, 1.41, -1.4, -4.22, 4.22, 1.41, -1.4, -4.23)
_OUSTER_LAST = (-19.99, -20.27, -20.57, -20.92, -21.22, -21.54, -21.82)
PUBLISHED: dict[Model, Published] = {
    "hdl64e": Published(
        spin=1,
        lasers=64,
        elevation_deg=tuple((_XIESC_RINGS[key], value * _DEGREE) for key, value in _XIESC.items()),
        left_deg=tuple((_XIESC_RINGS[key], (value - _XIESC_LEFT[29]) * _DEGREE) for key, value in _XIESC_LEFT.items()),
        points_a_second=1_333_000,
        noise_mm=8.0,
        bias_mm=18.3,
        source="64e_s3-xiesc.yaml; S2 data sheet: 2 cm, one sigma, of which 8 mm from pulse to pulse on KITTI's roads",
    ),
    "vlp16": Published(
        spin=-1,
        lasers=16,
        elevation_deg=tuple((ring, 15.0 - 2.0 * ring) for ring in range(16)),
        # Lasers -15, 1, -13, 3, ... fire 2.304 us apart, while the head turns by 3600 deg a second to the right.
        left_deg=tuple((15 - n // 2 if n % 2 == 0 else 7 - n // 2, -3600.0 * 2.304e-6 * n) for n in range(16)),
        points_a_second=300_000,
        noise_mm=8.0,
        bias_mm=30.0 / 3.0**0.5,
        source="user manual 63-9243: order, times, clockwise, +-3 cm, read as even; noise as the maker's HDL-64E",
    ),
    "os1_128": Published(
        spin=-1,
        lasers=128,
        elevation_deg=(*enumerate(_OUSTER), *enumerate(_OUSTER_LAST, start=121)),
        left_deg=tuple((ring, _OUSTER_RIGHT[0] - right) for ring, right in enumerate(_OUSTER_RIGHT)),
        points_a_second=2_621_440,
        noise_mm=15.0,
        bias_mm=0.0,
        source="metadata of part 840-103575-06 (ouster-sdk), clockwise; data sheet: repeats within 1.5 cm, zero bias",
    ),
    "safety2d": Published(
        spin=1,
        lasers=1,
        elevation_deg=((0, 0.0),),
        left_deg=((0, 0.0),),
        points_a_second=271 * 15,
        noise_mm=20.0,
        bias_mm=None,
        source="SICK 1067299: 1 deg, 15 turns a second, statistical error 20 mm; constant error without a source",
    ),
}
"""By the name of the preset."""


ROADS = {
    "over all points (%)": (26.36, 51.96),
    "within rings (%)": (12.09, 29.26),
    "from ring to ring (%)": (21.46, 43.23),
}
"""Relative spread of intensities on the road ahead, as ``sweeps.spread`` finds it in KITTI's sweeps 000008, 000142."""
