"""How drives go."""

from dataclasses import dataclass, field
from typing import Annotated

from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.distribution import Distribution


@dataclass(frozen=True)
@ranged
class DriveConfig:
    """Speeds, lengths and frames of drives."""

    drives: Annotated[int, Range(1, 100)] = 1
    """Drives in a scene, 1-100; the scene's observations are shared out evenly among them."""
    sequence: bool = True
    """Frames evenly in time from start to end of each drive; false = each observation from a drive of its own."""
    speed: Annotated[Distribution, Range(0.1, 6, "m/s")] | None = None
    """Of the vehicle between speeding up and braking (m/s), 0.1-6; null = the trajectory's own, see the docs."""
    acceleration: Annotated[float, Range(0.05, 5, "m/s^2")] = 0.5
    """Of speeding up and braking (m/s^2), 0.05-5."""
    length: Annotated[Distribution, Range(0.5, 40, "m")] = field(default=Distribution.uniform(3.0, 8.0))
    """Of a drive along the aisle, and of the straight before the corner of a turn-in at most (m), 0.5-40."""
    radius: Annotated[Distribution, Range(0.3, 6, "m")] = field(default=Distribution.uniform(1.4, 2.2))
    """Of the turn-in's quarter circle, driven by the vehicle's origin (m), 0.3-6."""
    start: Annotated[Distribution, Range(1.5, 20, "m")] = field(default=Distribution.uniform(5.0, 6.0))
    """Where an approach begins at most: from the fork tips (or the front) to the pockets' opening (m), 1.5-20."""
    stop: Annotated[Distribution, Range(0.3, 5, "m")] = field(default=Distribution.uniform(0.8, 1.0))
    """Where an approach and a turn-in end, the same way (m), 0.3-5; less than ``start``."""
    lateral: Annotated[Distribution, Range(-0.5, 0.5, "m")] = field(default=Distribution.normal(0.0, 0.05, -0.15, 0.15))
    """Shift of an approach or a turn-in to the side of the target's middle (m), -0.5 to 0.5."""
    heading_deg: Annotated[Distribution, Range(-20, 20, "deg")] = field(
        default=Distribution.normal(0.0, 1.5, -5.0, 5.0)
    )
    """Turn of a drive against the aisle, of an approach and a turn-in against the target (deg), -20 to 20."""

    def __post_init__(self) -> None:
        if self.stop.high >= self.start.low:
            raise ValueError(f"stop must stay below start, found {self.stop.high} and {self.start.low}")
