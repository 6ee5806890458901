"""The warehouses that a chain is trained on: many small datasets, made side by side until a time is over.

python -m trainings.warehouses [--minutes 240] [--processes 2] [--folder out/warehouses]

Given again it goes on: part n is always the same scenes, whoever makes it. ``train`` then reads what there is.
"""

import os
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import tyro

from trainings.data import TARGETS, Data
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.errors import SettleError, UnknownNameError, WorkerError
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.one_writer import one_writer
from warehouse_sim.output import make_folder
from warehouse_sim.processes import prepare_worker

FOLDER = Path("out/warehouses")
_VIEWS, _SCENES = 24, 2
_SEED = 38_000
"""Of part 0; part n has the n-th after it. Nothing is scored on seeds from here to 48,000."""
_VALIDATION_EVERY = 20
"""Parts to one that only validates."""
_ANYWHERE: dict[str, Any] = {
    "loads": {"empty_fraction": 0.7},
    "lanes": {"empties_fraction": 0.7},
    "staging": {"count": {"min": 4, "max": 8}, "depth": {"min": 1.2, "max": 6.0}},
    "clutter": {"count": {"min": 6, "max": 24}},
    "traffic": {"people": {"min": 0, "max": 2}, "cartons": {"min": 0, "max": 6}},
    "viewpoints": {
        "height": {"mean": 1.2, "std": 1.4, "min": 0.15, "max": 3.6},
        "distance": {"mean": 1.0, "std": 3.0, "min": 1.0, "max": 9.0},
        "pitch_deg": {"mean": -12, "std": 14, "min": -60, "max": 12},
        "roll_deg": {"mean": 0, "std": 5, "min": -10, "max": 10},
        "max_elevation_deg": 45,
    },
}
"""Empty pallets alone, in rows and in stacks, amid clutter, from near and above."""
_NO_PALLETS: dict[str, Any] = {
    "shelving": {"empty_slot_fraction": 1.0},
    "staging": {"count": 0},
    "clutter": {"count": {"min": 6, "max": 40}, "on_shelves": {"min": 0, "max": 60}},
    "traffic": {
        "trucks": 0,
        "forklifts": {"choices": [0, 1]},
        "pallet_jacks": {"choices": [0, 1]},
        "people": {"min": 0, "max": 4},
        "cones": {"min": 0, "max": 4},
        "cartons": {"min": 3, "max": 12},
    },
    "appearance": {"preset": {"choices": ["everyday", "wild"]}},
    "viewpoints": _ANYWHERE["viewpoints"] | {"kind": "post", "level": False},
}
"""Clutter, cartons, empty racks, people and trucks, and no pallet among them."""
_KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "pallets_anywhere": ("robust_pallets", _ANYWHERE),
    "no_pallets": ("domain_random", _NO_PALLETS),
    "shelves_without_pallets": ("small_parts", _NO_PALLETS),
}
"""Recipe and changes of its scene, of parts that are of no shipped recipe."""
CYCLE = (
    "selective_rack",
    "very_narrow_aisle",
    "dock_staging",
    "block_storage",
    "pallets_anywhere",
    "mixed_pallets",
    "domain_random",
    "drive_in",
    "conveyor_pickup",
    "selective_rack",
    "robust_pallets",
    "industrial",
    "very_narrow_aisle",
    "pallets_anywhere",
    "dock_staging",
    "distance_study",
)
"""What parts are of, in turn; layouts whose pallets were found least come twice."""
ON_REQUEST = ("no_pallets", "shelves_without_pallets")
"""What parts are of, in turn, where ``--only`` names these: networks of images learn there what is no pallet."""
_ONLY_TO_LEARN = ("robust_pallets", "pallets_anywhere", *ON_REQUEST)
"""With pallets of no catalog, which no one part shows all of, or with none: never for validation."""
_SENSORS: tuple[dict[str, Any], ...] = (
    {},
    {"choices": ["d455", "d435", "kinect_v1", "azure_kinect", "tof_industrial"]},
    {"camera": {"width": 640, "height": 480, "focal_px": 525.0}},
    {},
    {"camera": {"width": 1224, "height": 370, "focal_px": 721.5}},
    {"camera": {"width": 640, "height": 360, "focal_px": 460.0}},
)
"""Changes of the sensors, by turn of the cycle; the rig of the recipe beside others."""


@dataclass(frozen=True)
class Part(Data):
    """One small dataset of the outputs that networks of images read."""

    sensors: int = 0
    """Which of ``_SENSORS``."""

    def changed_recipe(self) -> Recipe:
        """Return the recipe that is generated."""
        name, scene = _KINDS.get(self.recipe, (self.recipe, {}))
        recipe = load_recipe(
            name,
            {
                "scene": scene | {"observations_per_scene": self.views, "targets": list(self.targets)},
                "sensors": {"outputs": ["rgb", "depth", "masks", "poses"], **_SENSORS[self.sensors]},
            },
        )
        split = self.split or recipe.split
        return replace(recipe, name=self.folder_name, scenes=self.scenes or recipe.scenes, split=split)


def part(number: int, cycle: tuple[str, ...] = CYCLE) -> Part:
    """Return part ``number``: 48 observations of one recipe, to learn from or, one in twenty, to validate on."""
    turn, place = divmod(number, len(cycle))
    recipe = cycle[place]
    validates = (number * 7) % _VALIDATION_EVERY == 0 and recipe not in _ONLY_TO_LEARN
    return Part(
        recipe,
        _SEED + number,
        f"{recipe}-{number:05d}",
        _SCENES,
        _VIEWS,
        SplitConfig(0.0, 1.0, 0.0) if validates else SplitConfig(1.0, 0.0, 0.0),
        targets=TARGETS,
        sensors=(turn + place) % len(_SENSORS),
    )


def finished(folder: Path = FOLDER) -> list[Path]:
    """Return the datasets that are complete, in order of their parts."""
    found = [path.parent for path in folder.glob("*/manifest.json")]
    return sorted(found, key=lambda path: path.name.rpartition("-")[2])


def main(
    minutes: float = 240.0,
    processes: int = os.cpu_count() or 1,
    folder: Path = FOLDER,
    first: int = 0,
    parts: int = 1042,
    only: tuple[str, ...] = (),
) -> None:
    """Make parts until the time is over; what is unfinished then is gone on with next time.

    Args:
        minutes: Time after which no part is begun (minutes).
        processes: Parts that are made at once.
        folder: Where they are kept.
        first: Number of the first part.
        parts: Most parts, of 48 observations each.
        only: Kinds of parts that are made, as ``CYCLE`` names them; all without it. Numbers of others are passed over.
            Those of ``ON_REQUEST`` are not joined with others.

    Raises:
        UnknownNameError: If ``only`` names a kind that there is not.
    """
    cycle = only if only and set(only) <= set(ON_REQUEST) else CYCLE
    for kind in only:
        if kind not in cycle:
            raise UnknownNameError("kind of part", kind, sorted({*CYCLE, *ON_REQUEST}))
    make_folder(folder)
    numbers = [number for number in range(first, first + parts) if not only or cycle[number % len(cycle)] in only]
    until = time.time() + 60.0 * minutes
    with one_writer(folder), ProcessPoolExecutor(processes, get_context("spawn"), prepare_worker) as pool:
        for _ in pool.map(partial(make_part, folder, until, cycle), numbers):
            pass
    print(f"{len(finished(folder))} parts in {folder}")


def make_part(folder: Path, until: float, cycle: tuple[str, ...], number: int) -> Path | None:
    """Make a part unless it is there, and return its folder; None where the time is over or no scene of it settles."""
    item = part(number, cycle)
    root = folder / item.folder_name
    if (root / "manifest.json").is_file():
        return root
    if time.time() > until:
        return None
    config = GenerateConfig(seed=item.seed, formats=item.formats, resume=root.exists(), skip_failed=True)
    try:
        generate(item.changed_recipe(), root, config)
    except (SettleError, WorkerError) as problem:
        print(f"{item.folder_name}: left out: {problem}")
        return None
    return root


if __name__ == "__main__":
    tyro.cli(main)
