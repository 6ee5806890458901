"""Scenes of the frozen recipe by some cameras, and what estimators say of their images with errors of masks."""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from warehouse_sim.benchmark.disturbances import Disturb
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.schema import PoseEstimate
from warehouse_sim.sensors.rgbd.depth import PRESETS

RECIPE = "industrial-v1"
LEARNT = "quadratic"
"""The camera that the models have learnt; others are presets of depth."""
VAL, TEST = SplitConfig(0.0, 1.0, 0.0), SplitConfig(0.0, 0.0, 1.0)
_IMAGES_AT_ONCE = 8


def made(root: Path, camera: str, scenes: int, views: int, seed: int, split: SplitConfig) -> Path:
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
            split=split,
        )
        workers = os.cpu_count() or 1
        config = GenerateConfig(scenes=scenes, seed=seed, formats=("bop",), workers=workers, resume=root.exists())
        generate(recipe, root, config)
    return root


def predict(estimator: PoseEstimator, images: Sequence[RgbdImage], disturb: Disturb) -> list[PoseEstimate]:
    """Return the estimates of disturbed images; each has a random stream of its own."""
    changed = [disturb(item, np.random.default_rng([0, item.scene_id, item.image_id])) for item in images]
    groups = [changed[start : start + _IMAGES_AT_ONCE] for start in range(0, len(changed), _IMAGES_AT_ONCE)]
    return [estimate for group in groups for estimate in estimator.estimate_all(group)]
