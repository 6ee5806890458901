"""One random stream a stage, so that any scene can be made alone and no stage disturbs another."""

import zlib

import numpy as np

from warehouse_sim.errors import RecipeError

_NUMBERS = {
    "impulses": 0x932297D0,
    "nominal": 0xB211F28A,
    "recipe layout.open_fraction": 0xEC4EF88B,
    "recipe layout.trailer_fraction": 0x44A87A9F,
    "recipe lights.hall_fraction": 0x2B383D7D,
    "recipe shelving.empty_slot_fraction": 0xD5D2E831,
}
"""Stages, or their first words, whose number is not their own CRC-32: the bytes of a seed hang on it."""


def stage_number(stage: str) -> int:
    """Return the number of a stage in a seed: the CRC-32 of its name, unless it has a number of its own."""
    if stage in _NUMBERS:
        return _NUMBERS[stage]
    first, blank, rest = stage.partition(" ")
    return zlib.crc32((blank + rest).encode(), _NUMBERS.get(first, zlib.crc32(first.encode())))


def scene_rng(seed: int, scene_index: int, stage: str, attempt: int = 0) -> np.random.Generator:
    """Return the random stream of one stage of one scene.

    Args:
        seed: Seed of the dataset, >= 0.
        scene_index: Number of the scene, >= 0.
        stage: Name of the stage ("loads", "lighting", ...); its number enters the seed.
        attempt: Number of the try, >= 0, when earlier tries gave no usable scene.

    Raises:
        RecipeError: A number is negative.
    """
    for name, value in (("seed", seed), ("scene index", scene_index), ("attempt", attempt)):
        if value < 0:
            raise RecipeError(f"the {name} must be >= 0, found {value}")
    return np.random.default_rng([seed, scene_index, stage_number(stage), attempt])
