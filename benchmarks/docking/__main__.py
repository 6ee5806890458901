"""Does the swept-volume check tell the ground truth? The same estimates, judged by it and by a simulated truck.

    python -m benchmarks.docking industrial mixed_pallets dock_staging --poses 1000 --write
    python -m benchmarks.docking DATA DATA=PREDICTIONS.csv

A RUN is a recipe (scenes are drawn here, errors planted), a dataset (errors planted) or a dataset with predictions.
"""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.benchmark.docking.pictures import picture
from warehouse_sim.benchmark.docking.record import (
    MARGINS_MM,
    Kept,
    Row,
    answer,
    by_kind,
    causes,
    confusion,
    described,
    disagreements,
)
from warehouse_sim.benchmark.docking.sources import Evaluated, Source
from warehouse_sim.benchmark.docking.truck import TRUCK

FOLDER = Path("out") / "docking"
_TABLES = [(margin, nominal) for nominal in (False, True) for margin in MARGINS_MM]


def main(
    runs: Annotated[tuple[str, ...], tyro.conf.Positional],
    /,
    poses: int = 1000,
    seed: int = 0,
    split: str = "test",
    folder: Path = FOLDER,
    show: int = 20,
    pictures: int = 0,
    write: bool = False,
) -> None:
    """Ask, count and print; what was answered before is not asked again.

    Args:
        runs: Recipes, datasets, or DATASET=PREDICTIONS.csv.
        poses: How many in all, the same number of each run as far as it has them.
        seed: Of drawn scenes and of planted errors.
        split: Of the datasets.
        folder: Where answers and pictures are kept.
        show: How many disagreements to print.
        pictures: How many of them to draw.
        write: Store the result file.
    """
    kept, rows, evaluated = Kept(folder / "answers.jsonl"), [], {}
    left_out: dict[str, dict[str, int]] = {}
    for name in runs:
        source = Source(name, seed, split)
        for question, station in source.questions(-(-poses // len(runs))):
            row = answer(kept, question, station)
            rows.append(row)
            if len(evaluated) < 50_000:
                evaluated[row["key"]] = (question, station)
        left_out[source.label] = dict(sorted(source.left_out.items()))
        print(f"{source.label}: {sum(row['source'] == source.label for row in rows)} poses asked", flush=True)
    _print(rows, left_out, show)
    _draw(disagreements(rows)[:pictures], evaluated, folder)
    if write:
        command = f"python -m benchmarks.docking {' '.join(runs)} --poses {poses} --seed {seed} --write"
        write_result(RESULTS / "docking.json", command, rounded(by_kind(rows)), **_facts(rows, left_out))


def _print(rows: list[Row], left_out: dict[str, dict[str, int]], show: int) -> None:
    for source, reasons in left_out.items():
        print(f"{source}: sides not asked: {', '.join(f'{why} {count}' for why, count in reasons.items()) or 'none'}")
    print("| swept-volume check with a margin | both dock | swept only | simulation only | neither | agree |")
    print("|---|---|---|---|---|---|")
    for margin, nominal in _TABLES:
        found = confusion(rows, margin, nominal)
        counts = " | ".join(str(found[name]) for name in ("both dock", "swept only", "simulation only", "neither"))
        low, high = found["agree_95"]
        print(f"| {margin} mm, {found['pockets']} | {counts} | {found['agree']:.3f} [{low:.3f}, {high:.3f}] |")
    for group in rounded(by_kind(rows)):
        print(", ".join(f"{name}: {value}" for name, value in group.items()))
    for why, count in causes(rows).items():
        print(f"differ: {count} x {why}")
    for row in disagreements(rows)[:show]:
        print(described(row))
    seconds = [row["cpu_s"] for row in rows]
    print(f"output: {len(rows)} poses, CPU {np.mean(seconds):.2f} s a pose, at most {max(seconds):.2f} s")


def _draw(rows: list[Row], evaluated: dict[str, Evaluated], folder: Path) -> None:
    for number, row in enumerate(rows):
        before, _, after = described(row).partition("; ")
        picture(folder / f"disagreement_{number:02d}.png", *evaluated[row["key"]], [before, after])


def _facts(rows: list[Row], left_out: dict[str, dict[str, int]]) -> dict[str, object]:
    return {
        "poses": len(rows),
        "truck": asdict(TRUCK),
        "confusion": [rounded(confusion(rows, margin, nominal)) for margin, nominal in _TABLES],
        "differ": causes(rows),
        "sides_not_evaluated": left_out,
        "cpu_s_a_pose": rounded(float(np.mean([row["cpu_s"] for row in rows]))),
        "disagreements": [described(row) for row in disagreements(rows)],
    }


if __name__ == "__main__":
    tyro.cli(main)
