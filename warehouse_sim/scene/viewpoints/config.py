"""What a recipe says about viewpoints."""

from dataclasses import dataclass, field
from typing import Literal

from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.viewpoints.drive_config import DriveConfig
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS, Mounting, ViewKind


@dataclass(frozen=True)
class ViewpointsConfig:
    """Which camera looks from where. Each view aims at one target, drawn evenly from those stored or in the aisle."""

    kind: ViewKind = "level"
    """Vehicle and mounting (level, forklift_mast, forklift_forks, forklift_guard, amr) or free, on a shell."""
    trajectory: Literal["none", "drive", "turn_in", "approach"] = "none"
    """Single views, or drives along the aisle, round a corner towards a target, straight up to a pallet's pockets."""
    level: bool = False
    """Whether the camera looks along the horizon, whatever its kind; KITTI knows no other."""
    distance: Distribution = field(default=Distribution.uniform(2.0, 8.0))
    """From the camera to the aimed-at target's centre (m), > 1: horizontally, for ``free`` along the line of sight."""
    height: Distribution | None = None
    """Height of the camera above the floor with forks lowered (m), > 0.1; null = the kind's own. Not for ``free``."""
    pitch_deg: Distribution | None = None
    """Tilt of the optical axis (deg), within +-60, negative = down; null = the kind's own. Not for ``free``."""
    elevation_deg: Distribution = field(default=Distribution.uniform(-15.0, 60.0))
    """Of a ``free`` camera above the target, seen from the target (deg), within +-85."""
    approach_deg: Distribution = field(default=Distribution.uniform(-30.0, 30.0))
    """Angle between the line of sight to the target and the direction straight into the rack (deg)."""
    offset_deg: Distribution = field(default=Distribution.uniform(-15.0, 15.0))
    """Angle between the optical axis and the line of sight to the target, seen from above (deg)."""
    aisle_share: float = 0.25
    """Share of the views that aim at a target in the aisle, where there is one, 0-1."""
    max_elevation_deg: float = 10.0
    """In view: largest angle of a target's centre above or below the optical axis (deg), 1-45."""
    max_bearing_deg: float = 35.0
    """In view: largest angle of a target's centre left or right of the optical axis (deg), 1-80."""
    sight_share: float = 0.6
    """In view: least share of a target's nine sample points that no object hides, 0-1."""
    min_targets: int = 1
    """Targets in view, the aimed-at one among them, 1-20."""
    clearance: float = 0.7
    """Least distance from the camera to any object (m), >= 0.2."""
    drive: DriveConfig = field(default_factory=DriveConfig)
    """How drives go, unless ``trajectory`` is none."""

    def __post_init__(self) -> None:
        if self.distance.low <= 1.0:
            raise ValueError(f"distance must stay above 1 m, found {self.distance.low}")
        if self.height is not None and self.height.low <= 0.1:
            raise ValueError(f"height must stay above 0.1 m, found {self.height.low}")
        for name, limit in (("pitch_deg", 60.0), ("elevation_deg", 85.0)):
            angles = getattr(self, name)
            if angles is not None and (angles.low < -limit or angles.high > limit):
                raise ValueError(f"{name} must stay within +-{limit:g}; give it min and max")
        for name, low, high in (
            ("aisle_share", 0.0, 1.0),
            ("max_elevation_deg", 1.0, 45.0),
            ("max_bearing_deg", 1.0, 80.0),
            ("sight_share", 0.0, 1.0),
            ("min_targets", 1, 20),
        ):
            if not low <= getattr(self, name) <= high:
                raise ValueError(f"{name} must be {low:g}-{high:g}, found {getattr(self, name)}")
        if self.clearance < 0.2:
            raise ValueError(f"clearance must be >= 0.2 m, found {self.clearance}")
        if self.pitch_deg is not None and (self.level or self.kind == "level"):
            raise ValueError("a level camera has no pitch: leave pitch_deg out, or level and the kind level")
        if self.kind == "free" and self.trajectory != "none":
            raise ValueError(
                f"a free camera does not drive: set trajectory none, not {self.trajectory}, or another kind"
            )

    @property
    def mounting(self) -> Mounting | None:
        """How the camera is carried; None for a free one."""
        return MOUNTINGS.get(self.kind)
