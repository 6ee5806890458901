"""What a robot's errors do to an estimator: outlines, neighbours, boxes and names that are wrong.

    python -m benchmarks.estimators.stress densefusion-depth rectangle-fit --write

The scenes are those of the frozen recipe from a seed that nothing was trained on; they are made where they are missing.
"""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import tyro

from benchmarks.estimators.data import FOLDER
from benchmarks.estimators.score import rows
from benchmarks.estimators.ways import open_way
from benchmarks.result import RESULTS, write_result
from warehouse_sim.benchmark.disturbances.masks import MASK_ERRORS, Disturb
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import predictions
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.predict import read_images
from warehouse_sim.evaluation import Scores, evaluate
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.schema import PoseEstimate

SEED = 41
SHOWN = ("add_5pct", "dock_0mm_2_7m", "dock_0mm", "dock_20mm")
_IMAGES_AT_ONCE = 8


def made(recipe: str, scenes: int, views: int, folder: Path) -> Path:
    """Return the folder of the scenes, generated first if it is not complete."""
    root = folder / "data" / f"stress_{recipe}"
    if not (root / "manifest.json").is_file():
        loaded = load_recipe(recipe)
        loaded = replace(
            loaded,
            name=root.name,
            scene=replace(loaded.scene, observations_per_scene=views),
            sensors=replace(loaded.sensors, lidar=None),
            split=SplitConfig(0.0, 0.0, 1.0),
        )
        config = GenerateConfig(
            scenes=scenes, seed=SEED, formats=("bop",), workers=os.cpu_count() or 1, resume=root.exists()
        )
        generate(loaded, root, config)
    return root


def predict(
    estimator: PoseEstimator, images: Sequence[RgbdImage], disturb: Disturb, seed: int = 0
) -> list[PoseEstimate]:
    """Return the estimates of disturbed images; each has a random stream of its own."""
    changed = [disturb(item, np.random.default_rng([seed, item.scene_id, item.image_id])) for item in images]
    batched = getattr(estimator, "estimate_all", None)
    if batched is None:
        return [estimate for image in changed for estimate in estimator.estimate(image)]
    groups = [changed[start : start + _IMAGES_AT_ONCE] for start in range(0, len(changed), _IMAGES_AT_ONCE)]
    return [estimate for group in groups for estimate in batched(group)]


def scored(estimates: Sequence[PoseEstimate], data: Path, place: Path, method: str) -> Scores:
    """Store estimates and return their scores."""
    predictions.write(place / "predictions.csv", estimates)
    return evaluate(place / "predictions.csv", data, "test", method=method)


def main(
    methods: tyro.conf.Positional[tuple[str, ...]],
    folder: Path = FOLDER,
    recipe: str = "industrial-v1",
    scenes: int = 24,
    views: int = 6,
    only: tuple[str, ...] = (),
    every: int = 1,
    write: bool = False,
) -> None:
    """Score estimators under every disturbance.

    Args:
        methods: Bundled models or run folders, perhaps with +verify, or registered estimators that need no training.
        folder: Where data, predictions and scores are kept.
        recipe: Whose scenes.
        scenes: Number of scenes.
        views: Observations of each scene.
        only: Names of disturbances; all by default.
        every: Every so manyth image, for a quick look; the others count as missed.
        write: Store the result.
    """
    data = made(recipe, scenes, views, folder)
    reader, found = DatasetReader(data), []
    for method in methods:
        estimator = open_way(method, reader.objects)
        images = list(read_images(estimator, reader, reader.images("test")[::every]))
        for name in only or MASK_ERRORS:
            place = folder / "scores" / Path(method).name / data.name / name.replace(" ", "_")
            scores = scored(predict(estimator, images, MASK_ERRORS[name]), data, place, f"{method}, {name}")
            for row in rows(scores, method, name, "pallet"):
                if row["metric"] in SHOWN:
                    found.append({**row, "name": f"{method}, {name}: {row['metric']}", "masks": name})
                    print(f"{found[-1]['name']:60} {row['value']:.3f} {row['interval']} n {row['n']}", flush=True)
    if write:
        size = f"--recipe {recipe} --scenes {scenes} --views {views}"
        command = f"python -m benchmarks.estimators.stress {' '.join(methods)} {size} --write"
        how = {"recipe": recipe, "seed": SEED, "scenes": scenes, "views": views}
        write_result(RESULTS / "stress.json", command, found, data=how)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
