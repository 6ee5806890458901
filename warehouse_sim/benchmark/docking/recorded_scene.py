"""A scene that a dataset records, sampled again with everything where the record has it."""

from dataclasses import replace
from functools import partial

import numpy as np

from warehouse_sim.dataset.stored.scene_record import SceneRecord
from warehouse_sim.errors import ConfigError, DatasetError, PlacementError
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.scene import sample_scene, scene_rng
from warehouse_sim.scene.layouts.site import Truck
from warehouse_sim.schema import SceneSpec


def recorded_scene(recipe: Recipe, record: SceneRecord, attempt: int, where: str) -> tuple[SceneSpec, Truck]:
    """Return a recorded scene with everything where the record has it, and the truck of its aisle.

    Args:
        recipe: What the dataset was made by.
        record: Of the scene.
        attempt: Which attempt stood, as the record's file says.
        where: The record's file, for errors.

    Raises:
        DatasetError: The recipe does not give the scene that is recorded.
    """
    try:
        settings = recipe.scene.sampled(partial(scene_rng, record.seed, record.scene_index, attempt=attempt))
        if recipe.occlusion is None:
            sampled = sample_scene(recipe.scene, record.seed, record.scene_index, attempt)
        else:  # what is put before the camera is chosen in the settled scene
            sampled = prepare_scene(recipe, record.seed, record.scene_index).scene
    except (ConfigError, PlacementError) as problem:
        raise DatasetError(f"{where}: {problem}; generate the dataset again with this version") from problem
    return _as_recorded(sampled, record, where), settings.layout.truck


def _as_recorded(sampled: SceneSpec, record: SceneRecord, where: str) -> SceneSpec:
    """Return the sampled scene with everything where the record has it."""
    models = {item.instance_id: item.model for item in sampled.instances}
    other = {item.instance_id: item.model for item in record.objects}
    differing = sorted(number for number in models.keys() | other.keys() if models.get(number) != other.get(number))
    if differing:
        number = differing[0]
        raise DatasetError(
            f"{where}: object {number} is {other.get(number)!r}, sampled again it is {models.get(number)!r}: this "
            "version samples other scenes from the recipe; use the version that the manifest names, or generate again"
        )
    places = {item.instance_id: np.asarray(item.T_world_object) for item in record.objects}
    instances = tuple(replace(item, T_world_object=places[item.instance_id]) for item in sampled.instances)
    return replace(sampled, instances=instances, settled=True)
