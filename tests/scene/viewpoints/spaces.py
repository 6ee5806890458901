"""Small scenes that viewpoints are chosen in."""

from functools import cache

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene import Distribution, SceneRecipe, sample_scene
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.loads.staging import StagingConfig
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.schema import SceneSpec

AREA = Area(-8.0, 8.0, -8.0, 0.0)


@cache
def aisle_scene(index: int, staged: int = 2) -> SceneSpec:
    """Return a scene with a rack of six bays and a few loads in the aisle."""
    recipe = SceneRecipe(
        layout=RackAisleConfig(bays=6),
        staging=StagingConfig(count=Distribution.constant(staged)),
        observations_per_scene=1,
    )
    return sample_scene(recipe, 3, index)


def bare_space(*placed: tuple[str, tuple[float, float, float], float]) -> FreeSpace:
    """Return an empty floor with objects: catalog name, centre (m) and heading (rad)."""
    draft = SceneDraft()
    draft.add("floor_slab", make_transform(translation=np.array([0.0, 0.0, -0.1])))
    for name, centre, yaw in placed:
        draft.add(catalog_object(name), make_transform(rotation_z(yaw), np.array(centre)))
    return FreeSpace.of(draft.instances, draft.models, ("pallet",), AREA)
