"""One random stream a stage, so that any scene can be made alone and no stage disturbs another."""

import zlib

import numpy as np

from warehouse_sim.errors import RecipeError


def scene_rng(seed: int, scene_index: int, stage: str, attempt: int = 0) -> np.random.Generator:
    """Return the random stream of one stage of one scene.

    Args:
        seed: Seed of the dataset, >= 0.
        scene_index: Number of the scene, >= 0.
        stage: Name of the stage ("loads", "lighting", ...); its CRC-32 enters the seed.
        attempt: Number of the try, >= 0, when earlier tries gave no usable scene.

    Raises:
        RecipeError: A number is negative.
    """
    for name, value in (("seed", seed), ("scene index", scene_index), ("attempt", attempt)):
        if value < 0:
            raise RecipeError(f"the {name} must be >= 0, found {value}")
    return np.random.default_rng([seed, scene_index, zlib.crc32(stage.encode()), attempt])
