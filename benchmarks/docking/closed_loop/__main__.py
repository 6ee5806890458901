"""Does the truck get there? The estimator in the loop: the truck sees, estimates, tracks, corrects, and goes in.

    python -m benchmarks.docking.closed_loop industrial dock_staging --episodes 20 --write

Episodes are kept line by line; a run that was stopped goes on.
"""

import time
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.benchmark.docking.closed_loop.episode import Row
from warehouse_sim.benchmark.docking.closed_loop.report import by_level, picture, table
from warehouse_sim.benchmark.docking.closed_loop.run import GT_MASKS, ORACLE, Runner
from warehouse_sim.benchmark.docking.closed_loop.settings import CONDITIONS, DRIFTS, DRIVE
from warehouse_sim.benchmark.docking.record import Kept
from warehouse_sim.benchmark.docking.truck import TRUCK
from warehouse_sim.render import open_renderer

FOLDER = Path("out") / "closed_loop"


def main(
    recipes: Annotated[tuple[str, ...], tyro.conf.Positional],
    /,
    episodes: int = 20,
    methods: tuple[str, ...] = (ORACLE, "rectangle-fit", "densefusion-depth"),
    levels: tuple[str, ...] = tuple(CONDITIONS),
    seed: int = 0,
    masks: str = GT_MASKS,
    min_score: float = 0.2,
    folder: Path = FOLDER,
    pictures: int = 0,
    write: bool = False,
) -> None:
    """Drive, dock, count and print.

    Args:
        recipes: Where scenes come from.
        episodes: Starts of each recipe; each is driven under every level by every method.
        methods: "ground truth", or estimators as tables name them.
        levels: Names of conditions (``settings.CONDITIONS``).
        seed: Of the scenes.
        masks: "gt" for the ground-truth mask of the pallet in each image, or a front end by name.
        min_score: Below this an estimate does not count; several in a row stop the truck.
        folder: Where episodes and pictures are kept.
        pictures: How many starts of each recipe to draw, under the first level, all methods in one picture.
        write: Store the result file.
    """
    started, rows = time.time(), list[Row]()
    kept, conditions = Kept(folder / "episodes.jsonl"), [CONDITIONS[name] for name in levels]
    with open_renderer("raster") as renderer:
        for recipe in recipes:
            runner = Runner(recipe, seed, methods, conditions, renderer, kept, masks, min_score)
            for row in runner.rows(episodes):
                rows.append(row)
                print(_line(row), flush=True)
            sampled = list(dict.fromkeys((row["scene"], row["start"]) for row in rows if row["source"] == recipe))
            for place in sampled[:pictures]:
                picture(folder / f"{recipe}_{place[0]}_{place[1]}.png", runner, *place)
    summaries = by_level(rows)
    print("\n".join(table(summaries)))
    if write:
        chosen = "" if levels == tuple(CONDITIONS) else " --levels " + " ".join(f"'{name}'" for name in levels)
        command = (
            f"python -m benchmarks.docking.closed_loop {' '.join(recipes)} --episodes {episodes} --methods "
            f"{' '.join(methods)}{chosen} --seed {seed} --masks {masks} --min-score {min_score:g} --write"
        )
        settings = {"drive": asdict(DRIVE), "truck": asdict(TRUCK)}
        settings |= {"drifts": {name: asdict(item) for name, item in DRIFTS.items()}}
        settings |= {"levels": [asdict(item) for item in conditions]}
        of_each = {recipe: rounded(by_level([row for row in rows if row["source"] == recipe])) for recipe in recipes}
        facts = {"seconds_of_this_call": round(time.time() - started), "settings": settings, "by_recipe": of_each}
        write_result(RESULTS / "closed_loop.json", command, rounded(summaries), **facts)


def _line(row: Row) -> str:
    place = f"{row['source']} {row['scene']}.{row['start']}, {row['condition']}, {row['method']}"
    if "errors" not in row:
        return f"{place}: {row['outcome']}"
    errors = row["errors"]
    return (
        f"{place}: {row['outcome']} after {row['time']:.0f} s, lateral {1e3 * errors['lateral']:+.0f} mm, depth "
        f"{1e3 * errors['depth']:+.0f} mm, yaw {57.29577951308232 * errors['yaw']:+.2f} deg"
    )


if __name__ == "__main__":
    tyro.cli(main)
