"""An order to the truck for one step, as numbers from -1 to 1 and in metres."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32

from warehouse_sim.benchmark.docking.closed_loop.settings import DRIVE
from warehouse_sim.errors import InputError, shown
from warehouse_sim.scene.viewpoints.mountings import FORKLIFT

Action = Float32[np.ndarray, " 5"]
"""Speed, curvature, whether to go in (> 0), how far, and how much higher the forks are then; each from -1 to 1."""
MOST_WAY = 2.0
"""Farthest that the truck goes in (m)."""
MOST_UP = 0.25
"""Farthest that the forks go up or down for it (m)."""


@dataclass(frozen=True)
class Command:
    """One order to the truck."""

    speed: float = 0.0
    """Wanted (m/s), 0 to that of the closed loop."""
    curvature: float = 0.0
    """Of its way (1/m), positive to the left, within the truck's least radius."""
    goes_in: bool = False
    """Whether it stops steering and goes straight in; this ends the episode."""
    way: float = 0.0
    """Then, how far (m)."""
    up: float = 0.0
    """And how much higher than now the tines are (m), negative = lower."""

    @classmethod
    def of(cls, action: Action) -> "Command":
        """Return the order that an action stands for; what is beyond -1 to 1 counts as its end.

        Raises:
            InputError: It is not five numbers.
        """
        values = np.asarray(action, dtype=float)
        if values.shape != (5,) or np.isnan(values).any():
            raise InputError(f"an action is five numbers from -1 to 1, found {shown(values.tolist())}")
        speed, curvature, goes_in, way, up = np.clip(values, -1.0, 1.0).tolist()
        return cls(
            max(speed, 0.0) * DRIVE.speed,
            curvature / FORKLIFT.min_radius,
            goes_in > 0.0,
            (way + 1.0) / 2.0 * MOST_WAY,
            up * MOST_UP,
        )

    @property
    def action(self) -> Action:
        """The action that stands for it."""
        values = [
            self.speed / DRIVE.speed,
            self.curvature * FORKLIFT.min_radius,
            1.0 if self.goes_in else -1.0,
            2.0 * self.way / MOST_WAY - 1.0,
            self.up / MOST_UP,
        ]
        return np.clip(values, -1.0, 1.0).astype(np.float32)
