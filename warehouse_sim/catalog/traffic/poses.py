"""How workers stand, walk, push, kneel and sit: angles of their limbs, and what brings both legs down to the floor."""

from collections.abc import Callable
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Pose:
    """Angles of the limbs in the vertical plane (deg), forwards positive; left, then right."""

    thighs: tuple[float, float]
    """Thighs against the vertical."""
    shanks: tuple[float, float]
    """Shanks against the vertical."""
    arms: tuple[float, float]
    """Upper arms against the vertical."""
    forearms: tuple[float, float]
    """Forearms against the vertical."""
    feet: tuple[float, float]
    """Feet against the floor, toes up positive."""
    lean: float = 0.0
    """Trunk, head and arms against the vertical, about the hips."""
    kneels: bool = False
    """Whether the right knee is on the floor, and the toes behind it."""
    sits: bool = False
    """Whether the feet rest wherever they are."""


POSES = {
    "standing": Pose((2.0, -1.0), (-2.0, -3.0), (-4.0, 6.0), (12.0, 62.0), (0.0, 0.0)),
    "walking": Pose((24.0, -16.0), (10.0, -38.0), (-24.0, 22.0), (-4.0, 44.0), (8.0, -26.0)),
}
"""Pose in the catalog name -> angles."""
WORKER_POSES = {
    "waiting": Pose((3.0, -2.0), (-1.0, -4.0), (-3.0, 14.0), (10.0, 96.0), (0.0, 0.0)),
    "striding": Pose((-18.0, 27.0), (-42.0, 12.0), (24.0, -26.0), (48.0, -2.0), (-28.0, 10.0), 4.0),
    "pushing": Pose((30.0, -14.0), (-4.0, -34.0), (42.0, 38.0), (74.0, 72.0), (0.0, -22.0), 12.0),
    "kneeling": Pose((92.0, 2.0), (2.0, -106.0), (34.0, 30.0), (62.0, 66.0), (0.0, -62.0), 16.0, kneels=True),
    "lifting": Pose((58.0, 44.0), (-24.0, -36.0), (28.0, 26.0), (46.0, 44.0), (0.0, -10.0), 38.0),
    "seated": Pose((84.0, 80.0), (20.0, 24.0), (34.0, 30.0), (82.0, 88.0), (4.0, 6.0), sits=True),
    "driving": Pose((4.0, -3.0), (0.0, -6.0), (22.0, 26.0), (78.0, 82.0), (0.0, 0.0), 2.0),
}
"""Pose in the catalog name of a finely divided worker -> angles; the last two are drivers', seated and standing."""
ON_TRUCKS = ("seated", "driving")
"""Poses of those who drive."""
FLAT = 0.008
"""Feet that differ by less (m) stand on the same floor."""
_STEPS = 16
"""Halvings of an angle: to a thousandth of a degree."""

Reach = Callable[[Pose, int], tuple[float, float]]
"""How far below the hip a pose's leg, 0 = left, reaches with its foot, and with its knee (m)."""


def planted(pose: Pose, reach: Reach) -> Pose:
    """Return ``pose`` with both legs on the floor: the thigh of the leg that hangs over it is turned until it is down.

    Who kneels has the front foot, a knee and the toes behind it there: the shank behind lifts the heel until the toes
    touch. Legs depend on the stature by more than a factor, as shoes do not grow with it.
    """
    if pose.sits:
        return pose
    if pose.kneels:
        return _knelt(pose, reach)
    left, right = (reach(pose, number)[0] for number in (0, 1))
    if abs(left - right) < FLAT:
        return pose
    short, floor = (0, right) if left < right else (1, left)
    return _lowered(pose, short, floor, reach, (0.0, pose.thighs[short]))


def _knelt(pose: Pose, reach: Reach) -> Pose:
    def lifted(angle: float) -> float:
        foot, knee = reach(_with_shank(pose, angle), 1)
        return foot - knee

    pose = _with_shank(pose, _solved(lifted, (-89.0, -130.0)))
    return _lowered(pose, 0, reach(pose, 1)[1], reach, (60.0, 120.0))


def _lowered(pose: Pose, number: int, floor: float, reach: Reach, between: tuple[float, float]) -> Pose:
    """Return ``pose`` with the thigh of a leg turned until its foot is ``floor`` (m) below the hip."""
    return _with_thigh(
        pose, number, _solved(lambda angle: reach(_with_thigh(pose, number, angle), number)[0] - floor, between)
    )


def _with_thigh(pose: Pose, number: int, angle: float) -> Pose:
    left, right = pose.thighs
    return replace(pose, thighs=(angle, right) if number == 0 else (left, angle))


def _with_shank(pose: Pose, right: float) -> Pose:
    return replace(pose, shanks=(pose.shanks[0], right))


def _solved(excess: Callable[[float], float], between: tuple[float, float]) -> float:
    """Return the angle at which ``excess``, positive at the first end and negative at the second, is none."""
    low, high = between
    for _ in range(_STEPS):
        middle = (low + high) / 2.0
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    return (low + high) / 2.0
