"""What some images of another sensor buy: a bundled estimator is trained on with 50, 200 and 1,000 images of a D455.

    python -m benchmarks.estimators.transfer densefusion-depth --write

Scenes are those of the frozen recipe, whose depth is ``quadratic`` through KITTI's image; the target sees them as a
D455 does, through its own image. Every size is also trained from fresh weights: the difference is the start's worth.
The fewer images are among the more. Runs that were interrupted go on.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tyro

from benchmarks.estimators.data import FOLDER
from benchmarks.estimators.shifted import rows_of
from benchmarks.estimators.shifts import Shift, made
from benchmarks.result import RESULTS, write_result
from warehouse_sim import train
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig

TRAINED_SEED, SCORED_SEED = 61, 62
VIEWS = 10
"""Images of a scene."""
_D455 = {
    "sensors": {
        "camera": {"width": 848, "height": 480, "focal_px": 446.8},
        "rgbd": {"depth": {"preset": "d455", "max_range": 20.0}},
        "lidar": None,
        "imu": None,
    }
}
_FOLDERS = SplitConfig(0.8, 0.2, 0.0)


def folder_of(images: int, folder: Path) -> Path:
    """Return a dataset of so many images, a fifth of them for validation; made where it is missing."""
    shift = Shift(f"d455 {images} images", "industrial-v1", _D455)
    return made(shift, max(images // VIEWS, 2), VIEWS, folder, TRAINED_SEED, _FOLDERS)


def trained(method: str, init: str | None, images: int, folder: Path, config: TrainConfig) -> Path:
    """Return the run of a method on so many images; one that is there is kept."""
    run = folder / "runs" / "transfer" / f"{method}_{images}_{'from_bundled' if init else 'fresh'}"
    if not (run / "result.json").is_file():
        train(method, folder_of(images, folder), run, config, resume=run.exists(), init=init)
    return run


def main(
    method: tyro.conf.Positional[str] = "densefusion-depth",
    folder: Path = FOLDER,
    counts: tuple[int, ...] = (50, 200, 1000),
    steps: int = 1500,
    minutes: float = 20.0,
    scenes: int = 12,
    views: int = 6,
    write: bool = False,
) -> None:
    """Train on with each number of images, and score on scenes that nothing was trained on.

    Args:
        method: Bundled estimator.
        folder: Where data, runs and scores are kept.
        counts: Numbers of images.
        steps: Optimiser steps of every training.
        minutes: Most minutes of every training.
        scenes: Scenes that are scored.
        views: Observations of each.
        write: Store the result.
    """
    scored = Shift("d455 scored", "industrial-v1", _D455)
    data = made(scored, scenes, views, folder, SCORED_SEED)
    config = TrainConfig(max_steps=steps, max_minutes=minutes, batch=32, learning_rate=5e-4, balance="crops", threads=1)
    found = _labelled(rows_of(method, scored, data, folder / "scores" / "transfer" / method), 0, "bundled")
    for images in counts:
        for start in (method, None):
            run = trained(method, start, images, folder, config)
            rows = rows_of(str(run), scored, data, folder / "scores" / "transfer" / run.name)
            found += _labelled(rows, images, "trained on" if start else "fresh")
    for row in found:
        if row["slice"] == "in range" and row["margin_mm"] == 0:
            low, high = row["interval"]
            print(f"{row['name']:70} {row['value']:.3f} [{low:.3f}, {high:.3f}] n {row['n']}", flush=True)
    if write:
        command = f"python -m benchmarks.estimators.transfer {method} --write"
        size = {"steps": steps, "scenes": scenes, "views": views}
        write_result(RESULTS / "transfer.json", command, found, seeds=[TRAINED_SEED, SCORED_SEED], **size)


def _labelled(rows: Sequence[dict[str, Any]], images: int, start: str) -> list[dict[str, Any]]:
    """Return rows that say how many images were trained on, and from which start."""
    return [
        {
            **row,
            "name": f"{start}, {images} images: docked, {row['slice']}, {row['margin_mm']} mm",
            "images": images,
            "start": start,
        }
        for row in rows
    ]


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
