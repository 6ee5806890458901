"""Some cartons are battered; places, ids and all other objects are those of the scene without."""

from dataclasses import replace

import numpy as np

from warehouse_sim.catalog.loads.carton_wear import CartonWearConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import sample_scene


def test_about_the_share_is_battered_and_nothing_else_changes() -> None:
    recipe = load_recipe("smoke").scene
    bare = sample_scene(recipe, 0, 1)
    rough = sample_scene(replace(recipe, carton_wear=CartonWearConfig(fraction=0.4)), 0, 1)
    cartons = battered = 0
    for a, b in zip(bare.instances, rough.instances, strict=True):
        assert (a.instance_id, a.group, a.dynamic) == (b.instance_id, b.group, b.dynamic)
        assert np.array_equal(a.T_world_object, b.T_world_object)
        assert a.model == b.model.split("~")[0]
        is_carton = bare.model_of(a).class_name == "carton"
        cartons, battered = cartons + is_carton, battered + (a.model != b.model)
        assert is_carton or a.model == b.model
    assert cartons > 10
    assert 0.1 < battered / cartons < 0.7
    assert len(rough.models) <= len(bare.models) + 3 * sum(
        model.class_name == "carton" for model in bare.models.values()
    )
    assert set(rough.models) == {item.model for item in rough.instances}
