"""How many contacts in settled scenes break the crush rule, and how many loads stand on less than 85 % of a layer.

    python -m benchmarks.acceptance.crush                        # prints the table
    python -m benchmarks.acceptance.crush --scenes 20 --write    # fewer scenes, and stores the result

The weights are those that the contacts of the settled scene give, not those that the packer reckoned with.
"""

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import Any

import tyro

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.errors import SettleError
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.sampled import sample_settled_scene
from warehouse_sim.physics import CrushState, crush_state
from warehouse_sim.resources import data_folder

FROZEN = ("industrial-v1",)
"""Recipes that are kept as they were, with the rule off."""


@dataclass
class Tally:
    """What was found in the scenes of one recipe."""

    scenes: int = 0
    first_draws: int = 0
    contacts: int = 0
    layers: int = 0
    highest: float = 0.0
    faults: Counter[str] = field(default_factory=Counter)

    def add(self, state: CrushState, attempt: int) -> None:
        """Count one scene."""
        self.scenes += 1
        self.first_draws += attempt == 0
        self.contacts += state.contacts
        self.layers += state.layers
        self.highest = max(self.highest, state.highest)
        self.faults.update(fault.kind for fault in state.faults)

    def row(self, name: str) -> dict[str, Any]:
        """Return the tally as a row of a result."""
        thin = self.faults["layer not full"]
        return {
            "name": name,
            "value": self.faults.total(),
            "scenes": self.scenes,
            "contacts that bear": self.contacts,
            "contacts that break the rule": self.faults.total() - thin,
            "layers and loads on goods": self.layers,
            "on less than 85 % of a layer": thin,
            "largest fraction of a strength": self.highest,
            "stood at first draw": self.first_draws,
        }


def tally(recipe: Recipe, scenes: int, seed: int, show: bool) -> Tally:
    """Draw, settle and ask ``scenes`` scenes of a recipe."""
    # Views cost time and bear nothing.
    plain = replace(recipe, scene=replace(recipe.scene, observations_per_scene=1))
    found = Tally()
    for index in range(scenes):
        try:
            sampled = sample_settled_scene(plain, seed, index)
        except SettleError as problem:
            print(problem, flush=True)
            continue
        state = crush_state(sampled.scene, sampled.report.struck)
        found.add(state, sampled.scene.attempt)
        for fault in state.faults if show else ():
            print(f"  scene {index}: {fault.text}", flush=True)
    return found


def shipped_recipes() -> list[str]:
    """Return the names of the recipes that keep the rule."""
    names = sorted(path.stem for path in data_folder("scenes").glob("*.yaml"))
    return [name for name in names if name not in FROZEN]


def main(
    recipes: tuple[str, ...] = (), scenes: int = 100, seed: int = 0, show: bool = False, write: bool = False
) -> None:
    """Count and print.

    Args:
        recipes: Names or paths of recipes; all that ship by default.
        scenes: Scenes of each.
        seed: Seed of the dataset.
        show: Print every fault.
        write: Store the result file.
    """
    rows = []
    for name in recipes or shipped_recipes():
        rows.append(rounded(tally(load_recipe(name), scenes, seed, show).row(name)))
        print(", ".join(f"{key}: {value}" for key, value in rows[-1].items()), flush=True)
    broken = sum(row["contacts that break the rule"] + row["on less than 85 % of a layer"] for row in rows)
    print(f"output: {broken} faults in {sum(row['scenes'] for row in rows)} scenes")
    if write:
        chosen = f"--recipes {' '.join(recipes)} " if recipes else ""
        command = f"python -m benchmarks.acceptance.crush {chosen}--scenes {scenes} --seed {seed} --write"
        write_result(RESULTS / "crush.json", command, rows)


if __name__ == "__main__":
    tyro.cli(main)
