"""Real LiDARs by name: settings from data sheets, drivers and recordings, each with where it comes from.

What is not said of a LiDAR is as in the defaults of ``LidarConfig``, which are the HDL-64E's.
"""

from typing import Any

# HDL-64E: one sigma of 2 cm, 5 ns, 50 m at 10 % and 120 m at 80 % remission, as the header of BLenSor's model states
# them after the S2 data sheet; the extinction is what makes both ranges true. 2 mrad is the usual figure for its
# divergence. The 2 cm split as two KITTI sweeps do: 8 mm from pulse to pulse (fourth differences along rings, 7.3-8.2
# mm on the road), the rest, 18 mm, from laser to laser (17-28 mm between rings on upright planes, which are not all
# flat). KITTI's files run counter-clockwise. Blooming: no source, a prior.
_HDL64E: dict[str, Any] = {}
# VLP-16: "up to +-3 cm", 100 m, 6 ns, 55.296 us a cycle, 3 x 1.2 mrad, clockwise, two returns (user manual). All lasers
# of a unit are evenly spread over +-3 cm, which has a standard deviation of 17.3 mm; from pulse to pulse it is taken to
# be as good as the maker's HDL-64E. That the 100 m hold for 80 % remission, as other sheets say of theirs, is an
# assumption; 40 m at 10 % follow from it.
_VLP16: dict[str, Any] = dict(
    azimuth_step_deg=55.296e-6 * 10.0 * 360.0,
    spin="clockwise",
    max_range=100.0,
    laser_bias=0.0173,
    dark_range=40.7,
    divergence_mrad=(3.0, 1.2),
    pulse_length=0.9,
    intensity_scale="diffuse100",
)
# OS1-128 (data sheet): 2,048 columns, 0.8-120 m at 80 %, 40 m at 10 %, 1.5 cm (one sigma of repetitions) under a strong
# signal and 10 cm at a signal-to-noise ratio of 12, zero bias, steps of 1.2 cm, 0.18 deg full width at half maximum,
# one return. Its columns are places of the encoder; it turns clockwise (sensor documentation).
_OS1_128: dict[str, Any] = dict(
    azimuth_step_deg=360.0 / 2048.0,
    spin="clockwise",
    azimuth_phase="fixed",
    min_range=0.8,
    range_noise=0.015,
    laser_bias=0.0,
    range_noise_weak=0.1,
    range_step=0.012,
    dark_range=41.4,
    extinction=0.0,
    divergence_mrad=(3.14, 3.14),
)
# SICK's 270 deg scanner with flexible fields, part 1067299 (data sheet): 15 turns a second, 1 deg, 0.05-10 m, 8 m at
# 10 %, statistical error below 2 cm. Its telegrams run from -45 to +225 deg, counter-clockwise, in whole steps (TiM
# manuals). Its divergence and its constant error are not in the sheet; 10 mrad and 1 cm are assumptions.
_SAFETY2D: dict[str, Any] = dict(
    turns_per_second=15.0,
    azimuth_step_deg=1.0,
    azimuth_range_deg=(-135.0, 135.0),
    azimuth_phase="fixed",
    min_range=0.05,
    max_range=10.0,
    range_noise=0.02,
    laser_bias=0.01,
    range_step=0.001,
    dark_range=8.0,
    extinction=0.0,
    divergence_mrad=(10.0, 10.0),
)
# OS1-64 and OS1-32: the same optics and 45 deg with 64 and 32 evenly spaced channels (data sheets): every second and
# fourth beam of the 128.
PRESETS = {
    "hdl64e": _HDL64E,
    "hdl64e_s2": {"model": "hdl64e_s2"} | _HDL64E,
    "vlp16": {"model": "vlp16"} | _VLP16,
    "os1_128": {"model": "os1_128"} | _OS1_128,
    "os1_64": {"model": "os1_128", "every_nth_beam": 2} | _OS1_128,
    "os1_32": {"model": "os1_128", "every_nth_beam": 4} | _OS1_128,
    "safety2d": {"model": "safety2d"} | _SAFETY2D,
}
"""What differs from the defaults, by the name of the preset; ``model`` says whose lasers it has."""
MOST_RETURNS = {"hdl64e": 2, "hdl64e_s2": 2, "vlp16": 2, "os1_128": 1, "safety2d": 1}
"""Of one pulse: two in the manuals of HDL-64E S2/S3 and VLP-16, one in the OS1's data sheet; SICK's is unknown."""
