"""Settings of the fit of pallet faces."""

from dataclasses import dataclass
from typing import Annotated

from warehouse_sim.ranges import Range, ranged


@dataclass(frozen=True)
@ranged
class FaceConfig:
    """How a face is fitted."""

    planes: Annotated[int, Range(1, 20)] = 3
    """Upright planes that are looked at, 1-20."""
    rounds: Annotated[int, Range(1, 10)] = 2
    """How often plane and face are fitted in turn, 1-10."""
    gravity: bool = True
    """Whether the image's gravity is believed; without it the floor in sight is, or the camera is taken for level."""
    gravity_deg: Annotated[float, Range(0.01, 30, "deg")] = 0.5
    """Standard deviation of gravity, and of a pallet's own tilt, 0.01-30."""
    floor_deg: Annotated[float, Range(0.01, 30, "deg")] = 0.7
    """Least standard deviation of gravity where the floor in sight gives it, 0.01-30."""
    level_deg: Annotated[float, Range(0.01, 45, "deg")] = 4.0
    """Standard deviation of gravity where the camera is taken for level, 0.01-45."""
    catalog_spread: Annotated[float, Range(0.0005, 0.1, "m")] = 0.004
    """How far pallets are from a CAD that is named (m), 0.0005-0.1."""
    range_bias: Annotated[float, Range(0, 0.2, "m")] = 0.01
    """Standard deviation of what all readings are off together (m), 0-0.2."""
    least_openings: Annotated[float, Range(0, 1000)] = 6.0
    """Log likelihood that the pockets must add; with less there is no answer, 0-1,000."""
