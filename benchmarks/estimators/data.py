"""The datasets that bundled estimators are trained and scored on; made when they are missing."""

import os
from dataclasses import dataclass, replace
from pathlib import Path

from warehouse_sim import generate, load_recipe
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.generation.plan import GenerateConfig

FOLDER = Path("out/estimators")


@dataclass(frozen=True)
class Data:
    """One dataset by its recipe and seed."""

    recipe: str
    """Shipped recipe."""
    seed: int
    """Seed of the dataset; those that are scored have others than those that are trained on alone."""
    test_scenes: int | None = None
    """Scenes of a dataset that is all test; by default the recipe's own number and split."""

    @property
    def name(self) -> str:
        """Name of the folder, and in tables."""
        return f"{self.recipe}_test" if self.test_scenes else self.recipe


SCORED = (Data("industrial", 0), Data("mixed_pallets", 0))
"""Their train split is trained on, val calibrates, test is scored: scenes that nothing has seen."""
CARTONS = (Data("industrial_cartons", 3, test_scenes=8), Data("mixed_cartons", 3, test_scenes=8))
"""Scored for their cartons: the two above label pallets only."""
TRAINED_ONLY = (
    Data("industrial_more", 1),
    Data("mixed_more", 1),
    Data("industrial_cartons", 2),
    Data("mixed_cartons", 2),
)


def made(data: Data, folder: Path = FOLDER) -> Path:
    """Return the dataset's folder, generated first if it is not complete."""
    root = folder / "data" / data.name
    if not (root / "manifest.json").is_file():
        print(f"generating {root}")
        recipe = load_recipe(data.recipe)
        if data.test_scenes:
            recipe = replace(recipe, name=data.name, scenes=data.test_scenes, split=SplitConfig(0.0, 0.0, 1.0))
        config = GenerateConfig(seed=data.seed, formats=("bop",), workers=os.cpu_count() or 1, resume=root.exists())
        generate(recipe, root, config)
    return root
