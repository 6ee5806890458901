"""How the truck drives and when it gives up, and which single thing a level of a factor changes.

All numbers were set before the first measured run. Where no source is named, a number is an assumption.
"""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Driving:
    """The truck's motion, its controller, and the limits at which it stops by itself."""

    speed: float = 0.4
    """Of the approach (m/s): within the 0.3-0.8 m/s that the package's approaches are driven at."""
    acceleration: float = 0.4
    """Of speeding up and braking (m/s^2)."""
    steer_rate: float = 0.7
    """Fastest turn of the steered wheel (rad/s)."""
    wheel_off: float = 0.15
    """While the wheel is farther than this from where it is sent (rad), the truck drives no faster than ..."""
    slow: float = 0.1
    """... this (m/s)."""
    tick: float = 0.05
    """Between two orders to the truck (s)."""
    period: float = 1.0
    """Between two images (s): as fast as a slow estimator on a truck's computer."""
    look_ahead: tuple[float, float] = (0.4, 1.5)
    """Least and greatest look-ahead of pure pursuit (m)."""
    look_fraction: float = 0.3
    """Look-ahead as a fraction of the way that is left: far away the truck turns in gently, near the face it holds the
    line."""
    tip_gap: float = 0.10
    """From the tips to the believed face where the truck stops steering and drives straight in (m), as
    ``Truck.start_gap`` and the outlines of accessibility have it."""
    max_lateral: float = 0.04
    """Farthest that the believed entry may then be beside the truck's axis (m), else it is ``misaligned``."""
    max_yaw: float = 0.0436
    """Greatest angle between them (rad), likewise: 2.5 degrees."""
    max_bearing: float = 1.0472
    """Greatest angle between the truck and the believed axis (rad), 60 degrees: more is ``out of reach``."""
    patience: int = 5
    """Images in a row without an estimate that counts, after which the truck stops."""
    blind: float = 0.8
    """From the tips to the believed face (m): nearer than this no image is missed, the pallet leaves the view."""
    max_time: float = 90.0
    """Longest approach (s)."""
    moved: tuple[float, float] = (0.010, 0.0087)
    """A new belief whose entry lies farther aside (m), or is turned by more (rad, half a degree), is a correction."""


DRIVE = Driving()


@dataclass(frozen=True)
class Drift:
    """Errors of odometry; each approach draws its own."""

    scale: float = 0.005
    """Standard deviation of the error of distance, as a fraction of it."""
    turn_deg: float = 0.1
    """Standard deviation of a steady error of heading (deg a metre)."""
    noise_deg: float = 0.05
    """Of a random one (deg at one metre, growing with the root of the way)."""


DRIFTS = {
    "none": Drift(0.0, 0.0, 0.0),
    "usual": Drift(),
    "strong": Drift(scale=0.02, turn_deg=1.0, noise_deg=0.2),
}
"""No source was found for numbers of forklifts: the usual one is that of calibrated encoders with a gyroscope, the
strong one that of slipping wheels."""


@dataclass(frozen=True)
class Condition:
    """One level of one factor; all else as in ``BASE``."""

    name: str = "base"
    factor: str = "base"
    light: str = "nominal"
    """Preset of docs/light.md."""
    visible: tuple[float, float] | None = None
    """Least and greatest visible fraction of the pallet in the first view, by something that leaves when the truck has
    driven ``hidden_for``; None hides nothing."""
    hidden_for: float = 1.0
    """Way of the truck after which what hides is gone (m)."""
    sensor: str = "own"
    """Model or preset of the depth camera, see docs/sensors.md; "own" is the recipe's."""
    delay: float = 0.2
    """From an image to its estimate (s)."""
    compensated: bool = True
    """Whether an estimate is placed where the truck was at its image, or (a fault) where it is when it comes."""
    drift: str = "usual"
    """One of ``DRIFTS``."""
    is_open: bool = False
    """Whether the truck drives blind after its first estimate: the trivial way."""


BASE = Condition()
CONDITIONS = {
    item.name: item
    for item in (
        BASE,
        replace(BASE, name="open loop", factor="loop", is_open=True),
        replace(BASE, name="delay 0 s", factor="delay", delay=0.0),
        replace(BASE, name="delay 0.5 s", factor="delay", delay=0.5),
        replace(BASE, name="delay 0.5 s, not compensated", factor="delay", delay=0.5, compensated=False),
        replace(BASE, name="no drift", factor="drift", drift="none"),
        replace(BASE, name="strong drift", factor="drift", drift="strong"),
        replace(BASE, name="open loop, strong drift", factor="loop", drift="strong", is_open=True),
        replace(BASE, name="ideal depth", factor="sensor", sensor="ideal"),
        replace(BASE, name="d455", factor="sensor", sensor="d455"),
        replace(BASE, name="tof_industrial", factor="sensor", sensor="tof_industrial"),
        replace(BASE, name="40-60 % visible at first", factor="occlusion", visible=(0.4, 0.6)),
        replace(BASE, name="15-35 % visible at first", factor="occlusion", visible=(0.15, 0.35)),
        replace(BASE, name="dim", factor="light", light="dim"),
        replace(BASE, name="night", factor="light", light="night"),
        replace(BASE, name="backlit", factor="light", light="backlit"),
    )
}
"""By name, the base first."""
