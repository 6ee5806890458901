"""Episodes of an agent, and what they come to."""

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np

from warehouse_sim.benchmark.docking.closed_loop.drive import DOCKED
from warehouse_sim.evaluation.intervals import fraction_interval
from warehouse_sim.gym.agents import Agent
from warehouse_sim.gym.docking import Docking

TRUNCATED = "timed out"
_RESAMPLES = 1000


@dataclass(frozen=True)
class Episode:
    """How one ended."""

    seed: int
    scene: int
    outcome: str
    """Of the simulated truck, "collided", or "timed out"."""
    reward: float
    """Sum over its steps."""
    steps: int
    reset_s: float
    """CPU seconds that its beginning took."""
    steps_s: float
    """CPU seconds of the environment in all steps."""


def episodes(env: gymnasium.Env[Any, Any], agent: Agent, seeds: Sequence[int]) -> Iterator[Episode]:
    """Drive one episode for each seed.

    Args:
        env: ``Docking``, as ``gymnasium.make`` returns it; it shows what the agent observes.
        agent: Drives.
        seeds: Of the episodes.
    """
    docking = env.unwrapped
    assert isinstance(docking, Docking)
    for seed in seeds:
        begun = time.process_time()
        observation, known = env.reset(seed=seed)
        reset_s = time.process_time() - begun
        agent.begin(known)
        reward, steps, steps_s, ended, truncated, info = 0.0, 0, 0.0, False, False, dict[str, Any]()
        while not ended and not truncated:
            action = agent.act(observation)
            begun = time.process_time()
            observation, gained, ended, truncated, info = env.step(action)
            steps_s += time.process_time() - begun
            reward, steps = reward + float(gained), steps + 1
        outcome = info.get("outcome", TRUNCATED)
        yield Episode(seed, docking.scene_index, outcome, reward, steps, reset_s, steps_s)


def summary(name: str, driven: Sequence[Episode]) -> dict[str, Any]:
    """Return the fraction that docks with its 95 % interval over scenes, how episodes end, and the steps a second."""
    docked = np.array([item.outcome == DOCKED for item in driven], dtype=float)
    scenes = np.array([item.scene for item in driven])
    steps = sum(item.steps for item in driven)
    return {
        "name": name,
        "value": float(docked.mean()),
        "interval": list(fraction_interval(docked, scenes, _RESAMPLES, np.random.default_rng(0))),
        "episodes": len(driven),
        "scenes": len(set(scenes.tolist())),
        "outcomes": dict(Counter(item.outcome for item in driven).most_common()),
        "mean_reward": float(np.mean([item.reward for item in driven])),
        "mean_steps": steps / len(driven),
        "steps_a_cpu_second": steps / sum(item.steps_s for item in driven),
        "steps_a_cpu_second_with_resets": steps / sum(item.steps_s + item.reset_s for item in driven),
    }
