from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import PlacementError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.scene import sample_scene
from warehouse_sim.scene.viewpoints.choose import blocked_views, replace_blocked_views
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.schema import ObjectInstance, SceneSpec

CONFIG = load_recipe("smoke").scene.viewpoints


@pytest.fixture(scope="module")
def scene() -> SceneSpec:
    return sample_scene(load_recipe("smoke").scene, 0, 0)


def blocked(scene: SceneSpec) -> SceneSpec:
    """Return the scene with a large carton half a metre before the camera of the first viewpoint."""
    model = catalog_object("carton_600x500x300")
    T = scene.viewpoints[0].T_world_camera
    there = make_transform(None, T[:3, 3] + 0.9 * T[:3, 2])
    carton = ObjectInstance(9999, model.name, there, dynamic=True, group=99)
    return replace(scene, models=scene.models | {model.name: model}, instances=(*scene.instances, carton))


def test_views_that_nothing_stands_before_stay(scene: SceneSpec) -> None:
    assert replace_blocked_views(scene, CONFIG, np.random.default_rng(0)) is scene


def test_a_lost_view_is_chosen_again_and_the_others_stay(scene: SceneSpec) -> None:
    crowded = blocked(scene)
    assert 0 in blocked_views(crowded, CONFIG, FreeSpace.of_scene(crowded))
    renewed = replace_blocked_views(crowded, CONFIG, np.random.default_rng(0))
    assert blocked_views(renewed, CONFIG, FreeSpace.of_scene(renewed)) == []
    assert not np.array_equal(renewed.viewpoints[0].T_world_camera, scene.viewpoints[0].T_world_camera)
    for number in set(range(len(scene.viewpoints))) - set(blocked_views(crowded, CONFIG, FreeSpace.of_scene(crowded))):
        assert renewed.viewpoints[number] is scene.viewpoints[number]


def test_a_blocked_drive_asks_for_another_scene(scene: SceneSpec) -> None:
    driven = tuple(replace(view, sequence=0) for view in scene.viewpoints)
    with pytest.raises(PlacementError, match="before the drive of viewpoint 0"):
        replace_blocked_views(blocked(replace(scene, viewpoints=driven)), CONFIG, np.random.default_rng(0))
