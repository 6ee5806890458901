"""The warehouses that a chain is trained on: many small datasets, made side by side until a time is over.

python -m benchmarks.front_ends.warehouses [--minutes 240] [--processes 2] [--folder out/warehouses]

Given again it goes on: part n is always the same scenes, whoever makes it. ``train`` then reads what there is.
"""

import itertools
import os
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import tyro

from benchmarks.estimators.data import Data
from benchmarks.front_ends.data import TARGETS
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.errors import SettleError, WorkerError
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.one_writer import one_writer
from warehouse_sim.output import make_folder

FOLDER = Path("out/warehouses")
_VIEWS, _SCENES = 24, 2
_SEED = 38_000
"""Of part 0; part n has the n-th after it. Nothing is scored on seeds from here to 48,000."""
_VALIDATION_EVERY = 20
"""Parts to one that only validates."""
CYCLE = (
    "selective_rack",
    "very_narrow_aisle",
    "dock_staging",
    "block_storage",
    "mixed_pallets",
    "domain_random",
    "drive_in",
    "conveyor_pickup",
    "selective_rack",
    "industrial",
    "very_narrow_aisle",
    "dock_staging",
    "distance_study",
)
"""Recipes of the parts in turn; layouts whose pallets were found least come twice."""
_OWN_SENSORS = ("industrial", "distance_study", "domain_random")
"""Every other of these has KITTI's camera instead of the warehouses' rig."""


@dataclass(frozen=True)
class Part(Data):
    """One small dataset without sweeps, which no network of images reads."""

    def changed_recipe(self) -> Recipe:
        """Return the recipe that is generated."""
        recipe = super().changed_recipe()
        return replace(recipe, sensors=replace(recipe.sensors, lidar=None, lidars={}))


def part(number: int) -> Part:
    """Return part ``number``: 48 observations of one recipe, to learn from or, one in twenty, to validate on."""
    turn, place = divmod(number, len(CYCLE))
    recipe = CYCLE[place]
    validates = (number * 7) % _VALIDATION_EVERY == 0
    return Part(
        recipe,
        _SEED + number,
        f"{recipe}-{number:05d}",
        _SCENES,
        _VIEWS,
        SplitConfig(0.0, 1.0, 0.0) if validates else SplitConfig(1.0, 0.0, 0.0),
        rig="dissertation" if recipe in _OWN_SENSORS and turn % 2 else "",
        targets=TARGETS,
    )


def finished(folder: Path = FOLDER) -> list[Path]:
    """Return the datasets that are complete, in order of their parts."""
    found = [path.parent for path in folder.glob("*/manifest.json")]
    return sorted(found, key=lambda path: path.name.rpartition("-")[2])


def main(minutes: float = 240.0, processes: int = os.cpu_count() or 1, folder: Path = FOLDER) -> None:
    """Make parts until the time is over; what is unfinished then is gone on with next time.

    Args:
        minutes: Time after which no part is begun (minutes).
        processes: Parts that are made at once.
        folder: Where they are kept.
    """
    make_folder(folder)
    until = time.time() + 60.0 * minutes
    with one_writer(folder), ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        for done in [pool.submit(_make_parts, folder, first, processes, until) for first in range(processes)]:
            done.result()
    print(f"{len(finished(folder))} parts in {folder}")


def _make_parts(folder: Path, first: int, step: int, until: float) -> None:
    for item in _missing(folder, first, step):
        if time.time() > until:
            return
        root = folder / item.folder_name
        config = GenerateConfig(seed=item.seed, formats=item.formats, resume=root.exists(), skip_failed=True)
        try:
            generate(item.changed_recipe(), root, config)
        except (SettleError, WorkerError) as problem:
            print(f"{item.folder_name}: left out: {problem}")


def _missing(folder: Path, first: int, step: int) -> Iterator[Part]:
    items = map(part, itertools.count(first, step))
    return (item for item in items if not (folder / item.folder_name / "manifest.json").is_file())


if __name__ == "__main__":
    tyro.cli(main)
