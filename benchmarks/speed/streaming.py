"""Observations that a network trains on: made as they are needed, against the same ones through files."""

import tempfile
from itertools import islice
from pathlib import Path
from typing import Any

import torch

from benchmarks.speed.cost import measure
from benchmarks.speed.subject import Settings
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.streamed import ObservedImage
from warehouse_sim.estimators.pose.densefusion.crops.cut import image_crops
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.stream import stream

_SCENES, _QUICK_SCENES = 4, 1
_CROP = CropConfig()
"""Points alone, as ``densefusion-pointcloud`` takes them."""


def streaming(settings: Settings) -> dict[str, Any]:
    """Return the row: CPU-seconds an observation, scene and drawing included, until its crops are cut."""
    recipe = load_recipe(settings.recipe)
    scenes = _QUICK_SCENES if settings.quick else _SCENES
    per_scene = recipe.scene.observations_per_scene * len(recipe.paired_variants.names())
    observations = scenes * per_scene
    # What is compiled and kept at the first scene is nobody's.
    list(islice(stream(recipe, settings.seed + 1), per_scene))
    ours, streamed = measure(_streamed, recipe, settings.seed, scenes)
    theirs, filed = measure(_filed, recipe, settings.seed, scenes)
    assert streamed == filed, "a stream and its files do not give the same crops"
    return {
        "what": "an observation that is trained on, until its crops are cut: scene, drawing, labels",
        "ours_cpu_s": ours.cpu_s / observations,
        "peer_cpu_s": theirs.cpu_s / observations,
        "peer": "the same through files",
        "how": "scenes of one seed, in one process, after one that warms up; files are BOP, written, read and cut",
        "observations_per_cpu_s": observations / ours.cpu_s,
        "peer_observations_per_cpu_s": observations / theirs.cpu_s,
        "note": "rates are those of one core, in CPU-seconds, which other work on the machine changes little",
        "crops": streamed,
        "observations": observations,
        "recipe": recipe.name,
        "threads": torch.get_num_threads(),
    }


def _streamed(recipe: Recipe, seed: int, scenes: int) -> int:
    images = map(ObservedImage, stream(recipe, seed, scenes=scenes))
    return sum(len(list(image_crops(image, image.record, _CROP, 0))) for image in images)


def _filed(recipe: Recipe, seed: int, scenes: int) -> int:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "dataset"
        generate(recipe, out, GenerateConfig(scenes=scenes, seed=seed, formats=("bop",)))
        reader = DatasetReader(out)
        images = [image for split in reader.splits for image in reader.images(split)]
        return sum(len(list(image_crops(reader, image, _CROP, 0))) for image in images)
