"""Who docks in the task for learning? A random agent, one that is shown poses, and estimators.

python -m benchmarks.speed.docking_task --episodes 40 --write
"""

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import gymnasium
import numpy as np
import tyro

from benchmarks.speed.result import RESULTS, rounded, write_result
from warehouse_sim.benchmark.docking.closed_loop.run import objects_of
from warehouse_sim.benchmark.entrants.ways import way_of
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.gym import ENVIRONMENT
from warehouse_sim.gym.agents import Agent, EstimatingAgent, PursuitAgent, RandomAgent
from warehouse_sim.gym.score import episodes as driven_by
from warehouse_sim.gym.score import summary


def main(
    recipe: str = "dock_staging",
    episodes: int = 40,
    scenes: int = 16,
    first_scene: int = 1000,
    methods: tuple[str, ...] = ("rectangle-fit", "densefusion-depth"),
    write: bool = False,
) -> None:
    """Drive, count and print.

    Args:
        recipe: Of the scenes.
        episodes: For each agent, seeds from 0 on.
        scenes: How many there are.
        first_scene: Index of the first one; agents that learn do so in others.
        methods: Estimators as tables name them.
        write: Store the result file.
    """
    rows, every = list[dict[str, Any]](), dict[str, Any]()
    for name, agent in _agents(recipe, methods):
        env = gymnasium.make(
            ENVIRONMENT, recipe=recipe, observes=agent.observes, scenes=scenes, first_scene=first_scene
        )
        found = []
        for item in driven_by(env, agent, range(episodes)):
            found.append(item)
            print(f"{name}, seed {item.seed}: {item.outcome} after {item.steps} steps, {item.reward:.2f}", flush=True)
        env.close()
        rows.append(summary(name, found))
        every[name] = [{key: asdict(item)[key] for key in ("seed", "scene", "outcome", "steps")} for item in found]
    for row in rows:
        print(rounded(row))
    if write:
        command = (
            f"python -m benchmarks.speed.docking_task --recipe {recipe} --episodes {episodes} --scenes {scenes} "
            f"--first-scene {first_scene} --methods {' '.join(methods)} --write"
        )
        write_result(RESULTS / "docking_task.json", command, rounded(rows), episodes=every)


def _agents(recipe: str, methods: tuple[str, ...]) -> Iterator[tuple[str, Agent]]:
    yield "random", RandomAgent(np.random.default_rng(0))
    yield "scripted, true poses", PursuitAgent()
    objects = objects_of(load_recipe(recipe))
    for method in methods:
        yield method, EstimatingAgent(way_of(method).open(objects), objects)


if __name__ == "__main__":
    tyro.cli(main)
