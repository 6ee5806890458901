"""Docking as a task for learning: ``gymnasium.make("warehouse_sim/Docking-v0")`` after ``import warehouse_sim.gym``."""

from warehouse_sim.optional import require, require_extra

ENVIRONMENT = "warehouse_sim/Docking-v0"
"""Its name."""
MOST_STEPS = 900
"""After so many steps an episode is truncated: 90 s, as in the closed loop."""

require_extra("generate", "for warehouse_sim.gym")
require("gymnasium", "gym", "for warehouse_sim.gym").register(
    id=ENVIRONMENT, entry_point="warehouse_sim.gym.docking:Docking", max_episode_steps=MOST_STEPS
)
