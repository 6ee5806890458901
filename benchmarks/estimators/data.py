"""The datasets that bundled estimators are trained and scored on; made when they are missing."""

import os
from dataclasses import dataclass
from pathlib import Path

from warehouse_sim import generate, load_recipe
from warehouse_sim.generation.plan import GenerateConfig

FOLDER = Path("out/estimators")


@dataclass(frozen=True)
class Data:
    """One dataset by its recipe and seed; scenes are the recipe's own number."""

    recipe: str
    """Shipped recipe, which is also the name of the folder."""
    seed: int
    """Seed of the dataset; those that are scored have 0, further training data has others."""


SCORED = (Data("industrial", 0), Data("mixed_pallets", 0))
"""Their train split is trained on, val calibrates, test is scored: scenes that nothing has seen."""
TRAINED_ONLY = (
    Data("industrial_more", 1),
    Data("mixed_more", 1),
    Data("industrial_cartons", 2),
    Data("mixed_cartons", 2),
)


def made(data: Data, folder: Path = FOLDER) -> Path:
    """Return the dataset's folder, generated first if it is not complete."""
    root = folder / "data" / data.recipe
    if not (root / "manifest.json").is_file():
        print(f"generating {root}")
        config = GenerateConfig(seed=data.seed, formats=("bop",), workers=os.cpu_count() or 1, resume=root.exists())
        generate(load_recipe(data.recipe), root, config)
    return root
