"""Fit the uncertainty of estimators on scenes of their own.

    python -m trainings.uncertainty densefusion-depth icp-multistart

It is fitted on the frozen recipe from a seed that nothing else uses, read by three depth cameras, with masks that are
right and wrong in four ways. Samples are kept, newer weights collect them again; ``uncertainty.yaml`` is written into
the models' folders. What it is worth is in the scores of every estimate: ``trust`` in scores.json.
"""

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import tyro

from trainings.data import FOLDER
from trainings.uncertainty_fit import fit
from trainings.uncertainty_samples import Samples, collect, joined
from warehouse_sim.benchmark.entrants.ways import way_of
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.estimators.pose.uncertainty.model import read_uncertainty, write_uncertainty
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.learning.run_folder import WEIGHTS
from warehouse_sim.sensors.rgbd.depth import PRESETS

RECIPE, SEED = "industrial-v1", 8
LEARNT = "quadratic"
"""The camera that the models have learnt; others are presets of depth."""
FITTED_ON: Mapping[str, tuple[str, ...]] = {
    LEARNT: ("exact", "dilated by 1 px", "as of a segmenter", "touching merged"),
    "d455": ("exact", "eroded by 1 px", "as of a segmenter", "touching merged"),
    "tof_industrial": ("exact", "dilated by 1 px", "as of a segmenter"),
}
"""Cameras, and the masks with each of them."""


def main(
    methods: tyro.conf.Positional[tuple[str, ...]],
    folder: Path = FOLDER,
    scenes: int = 12,
    views: int = 4,
    every: int = 1,
) -> None:
    """Fit the uncertainty of estimators and write it into their folders.

    Args:
        methods: Bundled models or run folders, perhaps with +verify, or registered estimators that need no training.
        folder: Where data and samples are kept.
        scenes: Number of scenes.
        views: Observations of each of them.
        every: Every so manyth image; the others count for nothing.
    """
    for method in methods:
        way, samples = way_of(method), samples_of(method, scenes, views, every, folder)
        model = fit(samples, *way.config.way)
        write_uncertainty(way.folder, read_uncertainty(way.folder).with_model(model))
        held = f"AUROC {model.auroc}, bound holds {model.coverage} on scenes left out"
        print(f"{method}: fitted on {model.samples}, {held}")


def samples_of(method: str, scenes: int, views: int, every: int, folder: Path) -> Samples:
    """Return what a method does on the scenes of the fit, collected first where it is not kept."""
    parts = []
    for camera, masks in FITTED_ON.items():
        data = made(folder / "data" / f"uncertainty_{camera}_{SEED}", camera, scenes, views)
        for name in masks:
            file = folder / "uncertainty" / Path(method).name / data.name / f"{name.replace(' ', '_')}.npz"
            if not _is_fresh(file, method):
                estimator = way_of(method).open(DatasetReader(data).objects, uncertainty=False)
                collect(estimator, data, "val", name, every).save(file)
                print(f"collected {file}", flush=True)
            parts.append(Samples.load(file))
    return joined(parts)


def made(root: Path, camera: str, scenes: int, views: int) -> Path:
    """Return the folder of the scenes as one camera reads them, generated first if it is not complete."""
    if not (root / "manifest.json").is_file():
        recipe = load_recipe(RECIPE)
        rgbd = recipe.sensors.rgbd
        if camera != LEARNT:
            rgbd = replace(rgbd, depth=replace(PRESETS[camera], max_range=20.0))
        recipe = replace(
            recipe,
            name=root.name,
            scene=replace(recipe.scene, observations_per_scene=views),
            sensors=replace(recipe.sensors, rgbd=rgbd, lidar=None),
            split=SplitConfig(0.0, 1.0, 0.0),
        )
        workers = os.cpu_count() or 1
        config = GenerateConfig(scenes=scenes, seed=SEED, formats=("bop",), workers=workers, resume=root.exists())
        generate(recipe, root, config)
    return root


def _is_fresh(file: Path, method: str) -> bool:
    weights = way_of(method).folder / WEIGHTS
    return file.is_file() and not (weights.is_file() and weights.stat().st_mtime > file.stat().st_mtime)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
