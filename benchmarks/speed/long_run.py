"""A long run: rate, memory and failures of thousands of observations, watched from outside and gone on with.

    OMP_NUM_THREADS=1 python -m benchmarks.speed.long_run --observations 5000 --workers 2 --folder /big/disk/run
    OMP_NUM_THREADS=1 python -m benchmarks.speed.long_run --observations 5000 --workers 2 --folder /big/disk/run --write

The second call goes on with the first wherever it was stopped, and stores the result at the end. ``watched.csv`` in
the folder has a row every few seconds: seconds, scenes that are done, resident MiB of all processes.
"""

import csv
import os
import subprocess
import sys
import time
from pathlib import Path

import tyro
from rich.console import Console

from benchmarks.speed.result import RESULTS, rounded, write_result
from warehouse_sim.generation.recipe import load_recipe

_PAGE_MIB = os.sysconf("SC_PAGE_SIZE") / 2**20
_WARM_UP = 0.1
"""Fraction of the scenes after which memory must not grow."""
COLUMNS = ("seconds", "scenes", "resident_mib")


def main(
    folder: Path,
    observations: int = 5000,
    recipe: str = "smoke",
    workers: int = 2,
    seed: int = 0,
    every_s: float = 5.0,
    write: bool = False,
    outputs: tuple[str, ...] = (),
) -> int:
    """Generate, watch and print; exit code 1 if the run failed.

    Args:
        folder: Where dataset and watched.csv lie; one that is there is gone on with.
        observations: At least so many, >= 1.
        recipe: Name or path of the recipe.
        workers: Processes, >= 1.
        seed: Seed of the dataset.
        every_s: Seconds between two looks.
        write: Store benchmarks/results/long_run.json.
        outputs: As those of ``generate``; the recipe's own by default.
    """
    loaded, console = load_recipe(recipe), Console()
    per_scene = loaded.scene.observations_per_scene * len(loaded.paired_variants.names())
    scenes = -(-observations // per_scene)
    data, table = folder / "data", folder / "watched.csv"
    folder.mkdir(parents=True, exist_ok=True)
    words = ["generate", recipe, "--out", str(data), "--scenes", str(scenes), "--seed", str(seed)]
    words += ["--workers", str(workers), "--formats", "bop", "--resume"]
    words += ["--outputs", *outputs] if outputs else []
    process = subprocess.Popen([sys.executable, "-m", "warehouse_sim", *words])
    watch(process, data, table, scenes, per_scene, every_s, console)
    rows = read_rows(table)
    if process.returncode or not rows:
        console.print(f"the run ended with exit code {process.returncode}; the same command goes on with it")
        return 1
    found = summary(rows, scenes, per_scene)
    console.print(found)
    if write:
        command = (
            f"python -m benchmarks.speed.long_run --observations {observations} --recipe {recipe} --workers {workers}"
            + (f" --outputs {' '.join(outputs)}" if outputs else "")
        )
        row = {"name": recipe, "value": found["growth"], "workers": workers, **found}
        write_result(RESULTS / "long_run.json", command, rounded([row]))
    return 0


def watch(
    process: subprocess.Popen[bytes],
    data: Path,
    table: Path,
    scenes: int,
    per_scene: int,
    every_s: float,
    console: Console,
) -> None:
    """Write a row every few seconds while a run lasts, and say how fast it is and when it will be done."""
    before = read_rows(table)
    offset, began, start = (before[-1][0] if before else 0.0), done_scenes(data), time.monotonic()
    with table.open("a", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        if not before:
            writer.writerow(COLUMNS)
        while process.poll() is None:
            seconds, done = time.monotonic() - start, done_scenes(data)
            writer.writerow((round(offset + seconds, 1), done, round(resident_mib(process.pid), 1)))
            stream.flush()
            rate = (done - began) / seconds if seconds > 0 else 0.0
            left = f"{(scenes - done) / rate:.0f} s left" if rate else "no rate yet"
            console.print(f"{done} of {scenes} scenes, {rate * per_scene:.2f} observations/s, {left}", style="dim")
            time.sleep(every_s)
        writer.writerow((round(offset + time.monotonic() - start, 1), done_scenes(data), 0.0))


def read_rows(table: Path) -> list[tuple[float, int, float]]:
    """Return seconds, scenes and resident MiB of each look, also of sessions before this one."""
    if not table.is_file():
        return []
    with table.open(encoding="utf-8", newline="") as stream:
        return [(float(row[0]), int(row[1]), float(row[2])) for row in list(csv.reader(stream))[1:]]


def summary(rows: list[tuple[float, int, float]], scenes: int, per_scene: int) -> dict[str, float]:
    """Return rate and growth of memory: the median of the last tenth of the looks over that after the warm-up."""
    looks = [row for row in rows if row[2] > 0]
    warm = [row for row in looks if row[1] >= _WARM_UP * scenes] or looks
    part = max(1, len(warm) // 10)
    first, last = (sorted(row[2] for row in some)[len(some) // 2] for some in (warm[:part], warm[-part:]))
    return {
        "observations": rows[-1][1] * per_scene,
        "seconds": rows[-1][0],
        "observations_per_s": rows[-1][1] * per_scene / rows[-1][0],
        "hours_for_50000": 50_000 * rows[-1][0] / max(rows[-1][1] * per_scene, 1) / 3600.0,
        "first_mib": first,
        "last_mib": last,
        "largest_mib": max(row[2] for row in looks),
        "growth": last / first,
    }


def done_scenes(data: Path) -> int:
    """Return how many scenes are stored."""
    return sum(path.suffix == ".json" for path in (data / "scenes").iterdir()) if (data / "scenes").is_dir() else 0


def resident_mib(pid: int) -> float:
    """Return the resident memory of a process and of those that it started (MiB); pages that they share count twice."""
    total, waiting = 0.0, [pid]
    while waiting:
        folder = Path("/proc") / str(waiting.pop())
        try:
            total += int((folder / "statm").read_text().split()[1]) * _PAGE_MIB
            waiting += map(int, (folder / "task" / folder.name / "children").read_text().split())
        except (OSError, ValueError):
            continue
    return total


if __name__ == "__main__":
    raise SystemExit(tyro.cli(main))
