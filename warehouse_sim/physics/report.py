"""What settling did to a scene, and what is wrong with the result."""

from dataclasses import dataclass

from warehouse_sim.errors import SettleError


@dataclass(frozen=True)
class SettleReport:
    """Numbers of one settled scene; it is good when ``problems`` is empty."""

    scene_index: int
    seed: int
    stacks: int
    """Stacks of loose objects that were settled, each in a model of its own."""
    duration: float
    """Longest simulated time of a stack until rest (s)."""
    max_speed: float
    """Largest speed of a body at the end (m/s)."""
    max_drift: float
    """Largest distance between a body's first and last place (m), before impulses."""
    max_tilt: float
    """Largest angle between a body's z axis before and after (rad), before impulses."""
    max_overlap: float
    """Largest depth of one object in another (m)."""
    max_gap: float
    """Largest gap between a loose object and the nearest thing under it (m)."""
    lowest: float
    """Lowest point of a loose object over the floor (m); negative is below it."""
    toppled: tuple[int, ...]
    """Instance ids of the bodies that tilted too far, before impulses."""
    struck: tuple[int, ...]
    """Groups of the unit loads that got an impulse."""
    shifted: tuple[int, ...]
    """Instance ids of the pieces that an impulse pushed aside by more than 20 mm, and no further."""
    leaning: tuple[int, ...]
    """Instance ids of the pieces that an impulse left leaning."""
    fallen: tuple[int, ...]
    """Instance ids of the pieces that an impulse brought down."""
    problems: tuple[str, ...]
    """One line each, naming the instances; empty = good."""

    def require_ok(self) -> None:
        """Do nothing for a good scene.

        Raises:
            SettleError: The scene has problems.
        """
        if self.problems:
            shown = "; ".join(self.problems[:3]) + (" ..." if len(self.problems) > 3 else "")
            raise SettleError(
                f"scene {self.scene_index} of seed {self.seed} is not at rest as it should be: {shown}; "
                "take another attempt, or lower the jitter of the recipe"
            )
