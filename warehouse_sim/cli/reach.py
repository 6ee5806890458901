"""``warehouse-sim reach``: what scenes made before do not say yet of the pallets that a truck can take."""

from pathlib import Path

import tyro

from warehouse_sim.cli.console import count_progress, finish
from warehouse_sim.optional import require_extra


def reach(data: tyro.conf.Positional[Path], splits: tuple[str, ...] = ()) -> None:
    """Store in a dataset of an older version by which sides a truck can take its pallets; generate does so itself.

    Nothing is rendered and no other file changes. Scenes that say it already are left as they are.

    Args:
        data: Dataset folder that generate made.
        splits: Splits whose scenes get it; all by default.
    """
    require_extra("generate", "to draw scenes again")
    from warehouse_sim.generation.reach_later import add_accessibility

    with count_progress("scenes") as progress:
        written = add_accessibility(data, splits, progress)
    print(f"{written} scene records now say which pallets a truck can take")
    finish(data, "validate", data)
