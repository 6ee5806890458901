"""Measure the speed of everything, with the peers in the same run.

    python -m benchmarks.speed                     # all rows: prints the table, writes benchmarks/results/speed.json
    python -m benchmarks.speed --only encoding     # some rows: prints them
    python -m benchmarks.speed --only encoding --merge   # some rows: renews them in benchmarks/results/speed.json
    python -m benchmarks.speed --quick --out x.json

Times are CPU-seconds of a process and all its threads, medians after a warm-up; ours and the peer's frames are drawn in
turns, each renderer in a process of its own.
"""

import json
import os
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import tyro
from rich.console import Console
from rich.table import Table

from benchmarks.speed.amodal_masks import amodal_masks
from benchmarks.speed.encoding import encoding
from benchmarks.speed.feeding import feeding
from benchmarks.speed.formats import formats
from benchmarks.speed.full_observation import full_observation
from benchmarks.speed.inference import inference
from benchmarks.speed.latency import latency
from benchmarks.speed.lidar import lidar
from benchmarks.speed.memory import memory
from benchmarks.speed.paired_variants import paired_variants
from benchmarks.speed.result import beside_stored, machine, rounded
from benchmarks.speed.rgbd_ids import compare
from benchmarks.speed.rgbd_models import rgbd_models
from benchmarks.speed.scaling import scaling
from benchmarks.speed.scoring import scoring
from benchmarks.speed.streaming import streaming
from benchmarks.speed.subject import Settings
from benchmarks.speed.training import training
from benchmarks.speed.training_observation import training_observation

RESULT = Path(__file__).parents[1] / "results" / "speed.json"
ROWS: dict[str, Callable[[Settings], dict[str, Any]]] = {
    "rgbd_ids_vs_pyrender": partial(compare, "pyrender"),
    "rgbd_ids_vs_mujoco": partial(compare, "mujoco"),
    "full_observation": full_observation,
    "training_observation": training_observation,
    "encoding": encoding,
    "formats": formats,
    "memory": memory,
    "scaling": scaling,
    "amodal masks": amodal_masks,
    "lidar": lidar,
    "rgbd_models": rgbd_models,
    "paired_variants": paired_variants,
    "inference": inference,
    "latency": latency,
    "training": training,
    "streaming": streaming,
    "feeding": feeding,
    "scoring": scoring,
}


def main(
    recipe: str = "selective_rack",
    seed: int = 0,
    quick: bool = False,
    only: tuple[str, ...] = (),
    out: Path | None = None,
    merge: bool = False,
) -> None:
    """Measure and print; with all rows also store the result.

    Args:
        recipe: Name or path of the recipe that scenes are drawn from.
        seed: Seed of the scenes.
        quick: Measure little, to see that everything runs.
        only: Rows to measure; all when omitted.
        out: File for the result; benchmarks/results/speed.json for a full run of all rows, none otherwise.
        merge: Renew the measured rows in benchmarks/results/speed.json, each with its own command.
    """
    unknown = sorted(set(only) - set(ROWS))
    if unknown:
        raise SystemExit(f"no such rows: {', '.join(unknown)}; known: {', '.join(ROWS)}")
    settings, console = Settings(recipe, seed, quick), Console(width=140)
    rows = []
    for name in only or ROWS:
        start = time.perf_counter()
        rows.append(_finished(name, ROWS[name](settings)))
        numbers = {key: rows[-1][key] for key in ("ours_cpu_s", "peer_cpu_s", "ratio", "value") if key in rows[-1]}
        console.print(f"{name}: {numbers}, measured in {time.perf_counter() - start:.0f} s", style="dim")
    console.print(_table(rows))
    _print_details(console, rows)
    if out is None and not only and not quick:
        out = RESULT
    command = _command(recipe, seed, quick, only)
    if merge:
        renewed = beside_stored(RESULT, [{**row, "command": command} for row in rows])
        out, result = RESULT, json.loads(RESULT.read_text(encoding="utf-8")) | {"rows": renewed}
    else:
        result = {"machine": machine(), "command": command, "rows": rows}
    if out is not None:
        out.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
        console.print(f"output: {out}")


def _command(recipe: str, seed: int, quick: bool, only: tuple[str, ...]) -> str:
    threads = os.environ.get("OMP_NUM_THREADS")
    words = [
        *[f"OMP_NUM_THREADS={threads}"] * bool(threads),
        "python -m benchmarks.speed",
        f"--recipe {recipe}",
        f"--seed {seed}",
    ]
    return " ".join([*words, *["--quick"] * quick, *(["--only", *only] if only else [])])


def _finished(name: str, row: dict[str, Any]) -> dict[str, Any]:
    """Return the row as it is stored; the ratio is that of the stored numbers."""
    row = rounded({"name": name, **row})
    if "peer_cpu_s" in row:
        row["ratio"] = rounded(row["peer_cpu_s"] / row["ours_cpu_s"])
    return row


def _table(rows: list[dict[str, Any]]) -> Table:
    table = Table(title="CPU-seconds")
    table.add_column("row", no_wrap=True)
    table.add_column("what")
    for heading in ("ours", "peer", "peer / ours", "target"):
        table.add_column(heading, justify="right")
    for row in rows:
        ours = f"{row['ours_cpu_s']:.4f}" if "ours_cpu_s" in row else f"{row['value']:.3f}"
        peer = f"{row['peer_cpu_s']:.4f}" if "peer_cpu_s" in row else ""
        ratio = f"{row['ratio']:.1f}x" if "ratio" in row else ""
        table.add_row(row["name"], row["what"], ours, peer, ratio, row.get("target", ""))
    return table


def _print_details(console: Console, rows: list[dict[str, Any]]) -> None:
    """Print the fractions of a full observation's stages, and the sizes of the scaling row."""
    by_name = {row["name"]: row for row in rows}
    if "full_observation" in by_name:
        table = Table("stage of an observation", "CPU-s", "fraction")
        row = by_name["full_observation"]
        for stage, seconds in row["stages_cpu_s"].items():
            table.add_row(stage, f"{seconds:.4f}", f"{row['fractions'][stage]:.0%}")
        console.print(table)
    if "scaling" in by_name:
        table = Table("instances", "triangles", "ours: CPU-s a frame", "load", "peer: CPU-s a frame", "load")
        for size in by_name["scaling"]["table"]:
            ours, theirs = (f"{size[f'{who}_cpu_s']:.3f}" for who in ("ours", "peer"))
            loads = [f"{size[f'{who}_load_cpu_s']:.2f}" for who in ("ours", "peer")]
            table.add_row(f"{size['instances']:,}", f"{size['triangles']:,}", ours, loads[0], theirs, loads[1])
        console.print(table)


if __name__ == "__main__":
    sys.exit(tyro.cli(main))
