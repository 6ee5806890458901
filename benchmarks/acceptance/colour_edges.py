"""How surely ``validate`` tells a colour image of its own place from one of another: ranks at the edges of depth.

    warehouse-sim bench all --quick                                           # makes data in out/bench/data
    python -m benchmarks.acceptance.colour_edges out/bench/data/*             # prints the table
    python -m benchmarks.acceptance.colour_edges out/bench/data/* --write     # and stores the result

Each view is held against its own colours, and against those of another view of the same dataset, drawn by seed: what
the second misses is what a single image that was exchanged may hide behind.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import tyro
from rich.console import Console
from rich.table import Table

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.dataset.checks.colour import LEAST_RANK, edge_rank
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.split import SPLITS


def main(data: tyro.conf.Positional[tuple[Path, ...]], views: int = 14, seed: int = 0, write: bool = False) -> None:
    """Measure and print.

    Args:
        data: Datasets of this package.
        views: Views of each, drawn by seed, >= 2.
        seed: Of the draws.
        write: Store the result file.
    """
    own, others = [], []
    for number, root in enumerate(sorted(data)):
        mine, strange = ranks(root, views, np.random.default_rng([seed, number]))
        own += mine
        others += strange
    rows = [row("their own colours", own), row("colours of another view", others)]
    table = Table("held against", "views", "lowest", "5 %", "median", f"below {LEAST_RANK}")
    for item in rows:
        numbers = (f"{item[key]:.3f}" for key in ("lowest", "low", "median"))
        table.add_row(item["name"], str(item["views"]), *numbers, f"{item['value']:.1%}")
    Console().print(table)
    if write:
        command = "python -m benchmarks.acceptance.colour_edges out/bench/data/* --write"
        write_result(RESULTS / "colour_edges.json", command, rounded(rows), datasets=len(data), seed=seed)


def ranks(root: Path, views: int, rng: np.random.Generator) -> tuple[list[float], list[float]]:
    """Return the ranks of views with their own colours, and with those of another one; no rank, no entry."""
    reader = DatasetReader(root)
    images = [image for split in SPLITS for image in reader.images(split)]
    chosen = [images[int(number)] for number in rng.choice(len(images), min(views, len(images)), replace=False)]
    seen = [
        (reader.rgb(image), reader.clean_depth(image) if reader.has_clean else reader.depth(image)) for image in chosen
    ]
    own = [edge_rank(rgb, depth) for rgb, depth in seen]
    others = [
        edge_rank(rgb, depth)
        for (rgb, _), (_, depth) in zip(seen, [*seen[1:], *seen[:1]], strict=True)
        if len(seen) > 1 and rgb.shape[:2] == depth.shape
    ]
    return [rank for rank in own if rank is not None], [rank for rank in others if rank is not None]


def row(name: str, found: Sequence[float]) -> dict[str, float | str]:
    """Return a row of the result; ``value`` is the fraction that ``validate`` calls wrong."""
    low, median = np.quantile(found, [0.05, 0.5])
    return {
        "name": name,
        "value": float(np.mean(np.array(found) < LEAST_RANK)),
        "views": len(found),
        "lowest": min(found),
        "low": float(low),
        "median": float(median),
    }


if __name__ == "__main__":
    tyro.cli(main)
