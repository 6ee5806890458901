"""The closed loop with the estimators of a suite."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from warehouse_sim.benchmark.docking.closed_loop.drive import ABORTS
from warehouse_sim.benchmark.docking.closed_loop.run import LEFT_OUT, ORACLE, Runner
from warehouse_sim.benchmark.docking.closed_loop.settings import CONDITIONS
from warehouse_sim.benchmark.docking.kept_rows import Kept
from warehouse_sim.benchmark.entrants.ways import Way
from warehouse_sim.benchmark.rows.simulated import Drive
from warehouse_sim.benchmark.suite import ApproachConfig
from warehouse_sim.errors import ConfigError
from warehouse_sim.render import open_renderer


def drives(config: ApproachConfig, ways: Mapping[str, Way], inputs: Mapping[str, Any], out: Path) -> Iterator[Drive]:
    """Yield how each episode ended, of the ground truth first; what was driven before is taken from ``out``.

    Args:
        config: Recipes, levels and how many starts.
        ways: Who estimates besides the ground truth.
        inputs: What else the answers of each depend on.
        out: Folder.

    Raises:
        ConfigError: There is no such level.
        PlacementError: A recipe leaves no clearance for a truck.
    """
    if strange := [name for name in config.levels if name not in CONDITIONS]:
        raise ConfigError(f"approach: levels: {strange[0]!r} is none; known: {', '.join(CONDITIONS)}")
    levels = [CONDITIONS[name] for name in config.levels]
    kept = Kept(out / "episodes.jsonl")
    with open_renderer("raster") as renderer:
        for recipe in config.recipes:
            runner = Runner(recipe, config.seed, (ORACLE, *ways), levels, renderer, kept, ways=ways, inputs=inputs)
            for row in runner.rows(config.episodes):
                if row["outcome"] != LEFT_OUT:
                    ended = row["outcome"]
                    yield Drive(
                        row["method"], recipe, row["condition"], row["scene"], ended == "docked", ended in ABORTS
                    )
