"""What some images of another sensor buy: an estimator of KITTI's image is trained on with images of a D455.

    python -m benchmarks.estimators.transfer densefusion-depth --write

Scenes are those of the frozen recipe, whose depth is ``quadratic`` through KITTI's image; the target sees them as a
D455 does, through its own image. What is gone on from must not have seen that sensor: a bundled estimator that has is
replaced by one that is trained here, on KITTI's image alone. Every size is also trained from fresh weights: the
difference is the start's worth. The fewer images are among the more. Runs that were interrupted go on.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from benchmarks.estimators.data import FOLDER, ROBUST, SCORED
from benchmarks.estimators.data import made as made_data
from benchmarks.estimators.marked import replace_table
from benchmarks.estimators.over_seeds import rounded, seed_interval
from benchmarks.estimators.score import DOCKING_RANGE, Setting, score
from benchmarks.estimators.shifts import Shift, made
from benchmarks.estimators.study import DOCUMENT
from benchmarks.estimators.upon import settings_upon
from benchmarks.result import RESULTS, write_result
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.estimators.pose.densefusion.run_config import read_config
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.estimators.train import train
from warehouse_sim.evaluation import Scores
from warehouse_sim.evaluation.intervals import fraction_interval, scene_bootstrap
from warehouse_sim.resources import model_dir

COMMAND = "python -m benchmarks.estimators.transfer --write"
TRAINED_SEED, SCORED_SEED = 61, 62
VIEWS = 10
"""Images of a scene."""
SETTINGS = (
    Setting("consensus", PredictConfig(selection="consensus", refine="none")),
    Setting("consensus + ICP", PredictConfig(selection="consensus", refine="icp")),
)
METRICS = {"add_5pct": "ADD < 5 % d", "dock_2_7m": "docked, 2-7 m"}
_D455 = {
    "sensors": {
        "camera": {"width": 848, "height": 480, "focal_px": 446.8},
        "rgbd": {"depth": {"preset": "d455", "max_range": 20.0}},
        "lidar": None,
        "imu": None,
    }
}
_FOLDERS = SplitConfig(0.8, 0.2, 0.0)
_DRAWS = 2000

Found = dict[tuple[str, int], list[dict[str, Scores]]]
"""Scores by setting of each seed, by start and number of images."""


def main(
    method: tyro.conf.Positional[str] = "densefusion-depth",
    init: str | None = None,
    folder: Path = FOLDER,
    counts: tuple[int, ...] = (50, 200, 1000),
    seeds: tuple[int, ...] = (0, 1, 2),
    steps: int = 800,
    source_steps: int = 3000,
    scenes: int = 12,
    views: int = 6,
    cache: Path | None = None,
    write: bool = False,
) -> None:
    """Train on with each number of images, and score on scenes that nothing was trained on.

    Args:
        method: Registered estimator.
        init: Bundled name or run folder that is gone on from; by default the bundled one of the method where it saw
            KITTI's image alone, else one that is trained here.
        folder: Where data, runs and scores are kept.
        counts: Numbers of images.
        seeds: One training each.
        steps: Optimiser steps of every training on the other sensor.
        source_steps: Those of the training on KITTI's image, where it is needed.
        scenes: Scenes that are scored.
        views: Observations of each.
        cache: Where crops are kept; the user's cache folder by default.
        write: Store the result and its table.
    """
    data = made(Shift("d455 scored", "industrial-v1", _D455), scenes, views, folder, SCORED_SEED)
    source = init or source_of(method, folder, source_steps, cache)
    found: Found = {("as it was", 0): [_scores(model_dir(source), data, folder)]}
    for seed in seeds:
        for images in counts:
            for start in (source, None):
                run = trained(method, start, source, images, seed, steps, folder, cache)
                key = "trained on" if start else "fresh", images
                found.setdefault(key, []).append(_scores(run, data, folder))
    rows = [row for key, items in found.items() for row in rows_of(*key, items)]
    rows += [row for images in counts for row in gains(found, images)]
    text = as_markdown(rows)
    print(text)
    if write:
        more = {"seeds": [TRAINED_SEED, SCORED_SEED, *seeds], "steps": steps, "scenes": scenes, "views": views}
        write_result(RESULTS / "transfer.json", f"python -m benchmarks.estimators.transfer {method} --write", rows,
                     method=method, source=Path(source).name, **more)  # fmt: skip
        print(f"output: {replace_table(DOCUMENT, COMMAND, text)}")


def source_of(method: str, folder: Path, steps: int, cache: Path | None) -> str:
    """Return what has learnt the method from KITTI's image alone: the bundled weights, or else a run of our own."""
    seen = {source.name for source in read_config(model_dir(method)).datasets}
    if not seen & {data.folder_name for data in ROBUST}:
        return method
    run = folder / "runs" / "transfer" / f"{method}_kitti_{steps}"
    if not (run / "result.json").is_file():
        config = _limited(settings_upon(method, [made_data(SCORED[0], folder)]), steps, 2e-3, 0)
        train(method, made_data(SCORED[0], folder), run, config, resume=run.exists(), cache=cache)
    return str(run)


def folder_of(images: int, folder: Path) -> Path:
    """Return a dataset of so many images, a fifth of them for validation; made where it is missing."""
    shift = Shift(f"d455 {images} images", "industrial-v1", _D455)
    return made(shift, max(images // VIEWS, 2), VIEWS, folder, TRAINED_SEED, _FOLDERS)


def trained(
    method: str,
    init: str | None,
    source: str,
    images: int,
    seed: int,
    steps: int,
    folder: Path,
    cache: Path | None,
) -> Path:
    """Return the run of a method on so many images; one that is there is kept.

    Args:
        method: Registered estimator.
        init: What is gone on from; None for fresh weights.
        source: Whose inputs and disturbances both have.
        images: Number of images.
        seed: Of the training.
        steps: Optimiser steps.
        folder: Where runs are kept.
        cache: Where crops are kept.
    """
    start = "from_source" if init else "fresh"
    run = folder / "runs" / "transfer" / f"{method}_{images}_{start}_{steps}_{seed}"
    if not (run / "result.json").is_file():
        data = folder_of(images, folder)
        # Fresh weights have further to go.
        config = _limited(settings_upon(source, [data]), steps, 5e-4 if init else 2e-3, seed)
        train(method, data, run, config, resume=run.exists(), init=init, cache=cache)
    return run


def _limited(config: TrainConfig, steps: int, learning_rate: float, seed: int) -> TrainConfig:
    return replace(
        config,
        max_steps=steps,
        max_minutes=None,
        batch=32,
        learning_rate=learning_rate,
        refiner_iterations=0,
        balance="crops",
        threads=1,
        workers=1,
        validations=1,
        seed=seed,
    )


def _scores(run: Path, data: Path, folder: Path) -> dict[str, Scores]:
    return score(run, data, "test", SETTINGS, folder / "scores" / "transfer" / run.name)


def passes(scores: Scores, metric: str) -> tuple[np.ndarray, np.ndarray]:
    """Return for each object that a metric counts whether it passes, and its scene."""
    table = scores.table
    if metric == "dock_2_7m":
        low, high = DOCKING_RANGE
        table = table.select(table.dockable & (table.distance >= low) & (table.distance < high))
        return table.docks().astype(float), table.scene_id
    return (table.add < 0.05 * table.diameter).astype(float), table.scene_id


def rows_of(start: str, images: int, items: Sequence[dict[str, Scores]]) -> list[dict[str, Any]]:
    """Return the fractions that pass, as rows of a result file: mean over the seeds, interval over test scenes."""
    found = []
    for setting in items[0]:
        for metric in METRICS:
            values, scenes = zip(*(passes(item[setting], metric) for item in items), strict=True)
            mean = np.mean(values, axis=0)
            low, high = fraction_interval(mean, scenes[0], _DRAWS, np.random.default_rng(0))
            found.append(
                {
                    "name": f"{start}, {images} images, {setting}: {metric}",
                    "start": start,
                    "images": images,
                    "setting": setting,
                    "metric": metric,
                    "value": round(float(mean.mean()), 5),
                    "interval": rounded((low, high)),
                    "seeds": rounded([value.mean() for value in values]),
                    "n": len(mean),
                }
            )
    return found


def gains(found: Found, images: int) -> list[dict[str, Any]]:
    """Return what so many images gain over none, and the start over fresh weights, with both kinds of interval."""
    rows, trained_on = [], found["trained on", images]
    for against, others in (("as it was", found["as it was", 0] * len(trained_on)), ("fresh", found["fresh", images])):
        for setting in trained_on[0]:
            for metric in METRICS:
                pairs = [(passes(a[setting], metric), passes(b[setting], metric))
                         for a, b in zip(trained_on, others, strict=True)]  # fmt: skip
                by_seed = np.stack([ours[0] - theirs[0] for ours, theirs in pairs])
                mean = by_seed.mean(axis=0)
                rows.append(
                    {
                        "name": f"{images} images against {against}, {setting}: {metric}",
                        "images": images,
                        "against": against,
                        "setting": setting,
                        "metric": metric,
                        "value": round(float(np.mean([ours[0].mean() for ours, _ in pairs])), 5),
                        "difference": round(float(mean.mean()), 5),
                        "difference_interval": rounded(seed_interval(by_seed.mean(axis=1))),
                        "scenes_interval": rounded(
                            scene_bootstrap(mean, pairs[0][0][1], _DRAWS, np.random.default_rng(0))
                        ),
                    }
                )
    return rows


def as_markdown(rows: Sequence[dict[str, Any]]) -> str:
    """Return the fractions in a table, and the gains below it."""
    titles = [f"{title}, {setting.name}" for setting in SETTINGS for title in METRICS.values()]
    lines = ["| start | images | " + " | ".join(titles) + " |", "|---|---|" + "---|" * len(titles)]
    fractions = [row for row in rows if "start" in row]
    for key in dict.fromkeys((row["start"], row["images"]) for row in fractions):
        cells = [_fraction(row) for row in fractions if (row["start"], row["images"]) == key]
        lines.append(f"| {key[0]} | {key[1] or '-'} | " + " | ".join(cells) + " |")
    lines += ["", "| gain | " + " | ".join(f"{title}: over seeds, over scenes" for title in titles) + " |"]
    lines.append("|---|" + "---|" * len(titles))
    found = [row for row in rows if "against" in row]
    for images, against in dict.fromkeys((row["images"], row["against"]) for row in found):
        cells = [_gain(row) for row in found if (row["images"], row["against"]) == (images, against)]
        lines.append(f"| {images} images against {against} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _fraction(row: dict[str, Any]) -> str:
    low, high = row["interval"]
    return f"{100 * row['value']:.1f} [{100 * low:.0f}, {100 * high:.0f}]"


def _gain(row: dict[str, Any]) -> str:
    intervals = row["difference_interval"], row["scenes_interval"]
    parts = [f"[{100 * low:+.1f}, {100 * high:+.1f}]" for low, high in intervals]
    return f"{100 * row['difference']:+.1f} " + ", ".join(parts)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
