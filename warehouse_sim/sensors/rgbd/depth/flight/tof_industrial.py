"""A time-of-flight camera as it rides on trucks, after recordings of pallet faces at 0.4-2 m.

The recordings (640 x 480, 463 px, 15 frames of five places, of which four at rest) have no paper; what is fitted to
them is said to be, and ``tests/sensors/rgbd/depth/recorded`` compares all of it with them.
"""

from warehouse_sim.sensors.rgbd.depth.flight.time_of_flight import TimeOfFlight

TOF_INDUSTRIAL = TimeOfFlight(
    min_range=0.15,
    max_range=4.0,
    focal_px=462.6,
    # Spread over time: 5, 11, 18 and 25 mm at 0.5, 1, 1.5 and 2 m on surfaces of about 0.3, whatever their angle.
    sigma_base=0.0,
    sigma_linear=0.0055,
    sigma_square=0.0007,
    sigma_angle=0.0,
    # Neighbours are alike by 0.85, 0.53 and 0.24 at 1, 2 and 3 px; measured 0.8, 0.5 and 0.25.
    smooth_px=1.25,
    fixed_pattern=0.007,
    unit_offset=0.01,
    unit_scale=0.003,
    wiggle=0.003,
    # No pixel between two ranges is dropped.
    sigma_lateral_px=1.3,
    min_coherence=0.0,
    min_signal=0.008,
    stray_light=0.01,
    # Floors before recorded faces are read where they are, within 0.5 %: little of the light by way of them is left.
    multipath=0.25,
    gloss_bias=0.06,
    reflections=1.0,
)
"""Of a unit with the number 0; ``unit`` names another."""
