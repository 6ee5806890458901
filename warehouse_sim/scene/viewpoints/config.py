"""What a recipe says about viewpoints and drives."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS, Mounting, ViewKind


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


@dataclass(frozen=True)
@ranged
class ViewpointsConfig:
    """Which camera looks from where. Each view aims at one target, drawn evenly from those stored or in the aisle."""

    kind: ViewKind = "level"
    """Mounting: level, forklift_mast, forklift_forks, forklift_guard, amr, post, ceiling; or free, on a shell."""
    trajectory: Literal["none", "drive", "turn_in", "approach"] = "none"
    """Single views, or drives along the aisle, round a corner towards a target, straight up to a pallet's pockets."""
    level: bool = False
    """Whether the camera looks along the horizon, whatever its kind."""
    distance: Annotated[Distribution, Range(1, 50, "m")] = field(default=Distribution.uniform(2.0, 8.0))
    """From the camera to the aimed-at target's centre (m), 1-50: horizontally, for ``free`` along the line of sight."""
    height: Annotated[Distribution, Range(0.1, 20, "m")] | None = None
    """Height of the camera above the floor with forks lowered (m), 0.1-20; null = the kind's own. Not for ``free``."""
    lift: Annotated[Distribution, Range(0, 12, "m")] | Literal["target"] | None = None
    """How far forks raise the camera above ``height`` (m), 0-12, of forklift_mast and forklift_forks; ``target``: from
    nothing to where they could enter the target. null = 0 where ``height`` is given, else target."""
    pitch_deg: Annotated[Distribution, Range(-90, 60, "deg")] | None = None
    """Tilt of the optical axis (deg), -90 to 60, negative = down; null = the kind's own. Not for ``free``."""
    roll_deg: Annotated[Distribution, Range(-10, 10, "deg")] = field(default=Distribution.constant(0.0))
    """Turn of a tilted camera about its optical axis (deg), -10 to 10; no mounting is exact."""
    elevation_deg: Annotated[Distribution, Range(-85, 85, "deg")] = field(default=Distribution.uniform(-15.0, 60.0))
    """Of a ``free`` camera above the target, seen from the target (deg), -85 to 85."""
    approach_deg: Annotated[Distribution, Range(-180, 180, "deg")] = field(default=Distribution.uniform(-30.0, 30.0))
    """Angle between the line of sight to the target and the direction straight into the rack (deg), -180 to 180."""
    offset_deg: Annotated[Distribution, Range(-180, 180, "deg")] = field(default=Distribution.uniform(-15.0, 15.0))
    """Angle between the optical axis and the line of sight to the target, seen from above (deg), -180 to 180."""
    along_fraction: Fraction = 0.0
    """Fraction of the views along the aisle, their target beside the axis, 0-1; not for ``free`` and ``ceiling``."""
    dockable_fraction: Fraction = 0.0
    """Fraction of the views from before a face by which a truck can take its pallet, as all stands at rest, 0-1; not
    for ``free``, ``ceiling`` and drives."""
    aisle_fraction: Fraction = 0.25
    """Fraction of the views that aim at a target in the aisle, where there is one, 0-1."""
    max_elevation_deg: Annotated[float, Range(1, 45, "deg")] = 10.0
    """In view: largest angle of a target's centre above or below the optical axis (deg), 1-45."""
    max_bearing_deg: Annotated[float, Range(1, 80, "deg")] = 35.0
    """In view: largest angle of a target's centre left or right of the optical axis (deg), 1-80."""
    sight_fraction: Fraction = 0.6
    """In view: least fraction of a target's nine sample points that no object hides, 0-1."""
    min_targets: Annotated[int, Range(1, 20)] = 1
    """Targets in view, the aimed-at one among them, 1-20."""
    clearance: Annotated[float, Range(0.2, 10, "m")] = 0.7
    """Least distance from the camera to any object (m), 0.2-10."""
    drive: DriveConfig = field(default_factory=DriveConfig)
    """How drives go, unless ``trajectory`` is none."""

    def __post_init__(self) -> None:
        if self.pitch_deg is not None and (self.level or self.kind == "level"):
            raise ValueError("a level camera has no pitch: leave pitch_deg out, or level and the kind level")
        if (self.roll_deg.low, self.roll_deg.high) != (0.0, 0.0) and (self.level or self.kind == "level"):
            raise ValueError("a level camera has no roll: leave roll_deg out, or level and the kind level")
        if self.lift not in (None, "target") and self.mounting is not None and not self.mounting.lifts:
            raise ValueError(f"a camera of the kind {self.kind} is not raised: leave lift out, or take forklift_mast")
        if self.kind == "ceiling" and (self.level or self.trajectory != "none"):
            raise ValueError("a ceiling camera neither looks along the horizon nor drives: take another kind")
        if self.kind == "free" and self.trajectory != "none":
            raise ValueError(
                f"a free camera does not drive: set trajectory none, not {self.trajectory}, or another kind"
            )

        if self.dockable_fraction and (self.kind in ("free", "ceiling") or self.trajectory != "none"):
            raise ValueError(
                f"views before pallets that a truck can take are single ones from the floor: leave dockable_fraction "
                f"out, or the kind {self.kind} and the trajectory {self.trajectory}"
            )

    @property
    def mounting(self) -> Mounting | None:
        """How the camera is carried; None for a free one."""
        return MOUNTINGS.get(self.kind)
