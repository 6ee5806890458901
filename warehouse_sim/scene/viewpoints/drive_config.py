"""How drives go."""

from dataclasses import dataclass, field

from warehouse_sim.scene.distribution import Distribution


@dataclass(frozen=True)
class DriveConfig:
    """Speeds, lengths and frames of drives."""

    drives: int = 1
    """Drives in a scene, 1-100; the scene's observations are shared out evenly among them."""
    sequence: bool = True
    """Frames evenly in time from start to end of each drive; false = each observation from a drive of its own."""
    speed: Distribution | None = None
    """Of the vehicle between speeding up and braking (m/s), 0.1-6; null = the trajectory's own, see the docs."""
    acceleration: float = 0.5
    """Of speeding up and braking (m/s^2), 0.05-5."""
    length: Distribution = field(default=Distribution.uniform(3.0, 8.0))
    """Of a drive along the aisle, and of the straight before the corner of a turn-in at most (m), 0.5-40."""
    radius: Distribution = field(default=Distribution.uniform(1.4, 2.2))
    """Of the turn-in's quarter circle, driven by the vehicle's origin (m), 0.3-6."""
    start: Distribution = field(default=Distribution.uniform(5.0, 6.0))
    """Where an approach begins at most: from the fork tips (or the front) to the pockets' opening (m), 1.5-20."""
    stop: Distribution = field(default=Distribution.uniform(0.8, 1.0))
    """Where an approach and a turn-in end, the same way (m), 0.3-5; less than ``start``."""
    lateral: Distribution = field(default=Distribution.normal(0.0, 0.05, -0.15, 0.15))
    """Shift of an approach or a turn-in to the side of the target's middle (m), within +-0.5."""
    heading_deg: Distribution = field(default=Distribution.normal(0.0, 1.5, -5.0, 5.0))
    """Turn of a drive against the aisle, of an approach and a turn-in against the target (deg), within +-20."""

    def __post_init__(self) -> None:
        if not 1 <= self.drives <= 100:
            raise ValueError(f"drives must be 1-100, found {self.drives}")
        if not 0.05 <= self.acceleration <= 5.0:
            raise ValueError(f"acceleration must be 0.05-5 m/s^2, found {self.acceleration}")
        for name, low, high in (
            ("speed", 0.1, 6.0),
            ("length", 0.5, 40.0),
            ("radius", 0.3, 6.0),
            ("start", 1.5, 20.0),
            ("stop", 0.3, 5.0),
            ("lateral", -0.5, 0.5),
            ("heading_deg", -20.0, 20.0),
        ):
            values = getattr(self, name)
            if values is not None and (values.low < low or values.high > high):
                raise ValueError(f"{name} must stay within {low:g} to {high:g}; give it min and max")
        if self.stop.high >= self.start.low:
            raise ValueError(f"stop must stay below start, found {self.stop.high} and {self.start.low}")
