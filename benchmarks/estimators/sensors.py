"""What each depth camera does to the bundled estimators: the same scenes, views and masks, read by every preset.

    python -m benchmarks.estimators.sensors --write       # makes out/estimators/data/sensor_* first if missing

The scenes are those of the frozen recipe that the models were trained for, from a seed of their own. Only the depth
that is read differs, and colour where it is said; ``quadratic`` is what the models have learnt.
"""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import tyro

from benchmarks.estimators.data import FOLDER
from benchmarks.estimators.score import Setting, rows, score
from benchmarks.result import RESULTS, write_result
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.resources import data_folder
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.sensors.rgbd.color import ColorConfig
from warehouse_sim.sensors.rgbd.depth import PRESETS

RECIPE, SEED = "industrial-v1", 16
METHODS = ("densefusion", "densefusion-depth", "densefusion-pointcloud")
SETTING = Setting("consensus + ICP", PredictConfig(selection="consensus", refine="icp"))
SHOWN = ("add_5pct", "dock_0mm_2_7m")


def cameras() -> dict[str, RgbdConfig]:
    """Return what reads, by name: the learnt camera, it with colour as by default, and every preset of depth."""
    learnt = load_recipe(RECIPE).sensors.rgbd
    return {
        "quadratic": learnt,
        "quadratic, developed colour": replace(learnt, color=ColorConfig()),
        **{name: replace(learnt, depth=replace(model, max_range=20.0)) for name, model in PRESETS.items()},
    }


def made(name: str, rgbd: RgbdConfig, scenes: int, views: int, folder: Path) -> Path:
    """Return the folder of the scenes as one camera reads them, generated first if it is not complete."""
    root = folder / "data" / f"sensor_{name.replace(', ', '_').replace(' ', '_')}"
    if not (root / "manifest.json").is_file():
        recipe = load_recipe(RECIPE)
        recipe = replace(
            recipe,
            name=root.name,
            scene=replace(recipe.scene, observations_per_scene=views),
            sensors=replace(recipe.sensors, rgbd=rgbd, lidar=None),
            split=SplitConfig(0.0, 0.0, 1.0),
        )
        config = GenerateConfig(
            scenes=scenes, seed=SEED, formats=("bop",), workers=os.cpu_count() or 1, resume=root.exists()
        )
        generate(recipe, root, config)
    return root


def main(
    folder: Path = FOLDER,
    scenes: int = 16,
    views: int = 6,
    methods: Sequence[str] = METHODS,
    write: bool = False,
) -> None:
    """Score the models under every camera.

    Args:
        folder: Where data, predictions and scores are kept.
        scenes: Number of scenes.
        views: Observations of each scene.
        methods: Bundled models.
        write: Store the result.
    """
    found = []
    for name, rgbd in cameras().items():
        data = made(name, rgbd, scenes, views, folder)
        for method in methods:
            place = folder / "scores" / method / data.name
            scores = score(data_folder("models") / method, data, "test", [SETTING], place)[SETTING.name]
            for row in rows(scores, method, SETTING.name, "pallet"):
                if row["metric"] in SHOWN:
                    found.append({**row, "name": f"{method}, {name}: {row['metric']}", "sensor": name})
                    print(f"{found[-1]['name']:60} {row['value']:.3f} {row['interval']} n {row['n']}", flush=True)
    if write:
        command = f"python -m benchmarks.estimators.sensors --scenes {scenes} --views {views} --write"
        how = {"recipe": RECIPE, "seed": SEED, "scenes": scenes, "views": views, "setting": SETTING.name}
        write_result(RESULTS / "sensors.json", command, found, data=how)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
