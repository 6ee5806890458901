"""Views of a truck that comes to take something, judged by angles and by the boxes of the scene at rest."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.annotate.dockable import dockable_headings, entries_of
from warehouse_sim.annotate.trucks import TRUCKS
from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import ConfigError, PlacementError
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import SampledScene, sample_settled_scene
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.scene import sample_scene
from warehouse_sim.scene.viewpoints.choose import blocked_views, replace_blocked_views
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.schema import ObjectInstance, SceneSpec, Viewpoint


def recipe(fraction: float) -> Recipe:
    """Return the recipe with racks of five short and low lanes."""
    layout = {"lanes": 5, "lane_depth": 3, "levels": 2, "sides": "one"}
    views = {"dockable_fraction": fraction}
    return load_recipe("drive_in", {"scene": {"layout": layout, "viewpoints": views, "observations_per_scene": 8}})


@pytest.fixture(scope="module")
def before() -> SampledScene:
    return sample_settled_scene(recipe(0.0), 4711, 1)


@pytest.fixture(scope="module")
def all_dockable() -> SampledScene:
    return sample_settled_scene(recipe(1.0), 4711, 1)


def off_straight(view: Viewpoint, sampled: SampledScene) -> float:
    """Return the least angle (deg) between the line of sight to a view's target and straight into a free face."""
    scene = sampled.scene
    headings = dockable_headings(scene, TRUCKS[sampled.settings.layout.truck])
    if view.target not in headings:
        return 180.0
    target = next(item for item in scene.instances if item.instance_id == view.target)
    across = target.T_world_object[:2, 3] - view.T_world_camera[:2, 3]
    sight = np.arctan2(across[1], across[0])
    turned = [abs((sight - into + np.pi) % (2 * np.pi) - np.pi) for into in headings[view.target]]
    return float(np.rad2deg(min(turned)))


def test_all_views_come_to_take_something(before: SampledScene, all_dockable: SampledScene) -> None:
    """Headings are those of the pockets themselves; by chance hardly any view of a lane is such a one."""
    assert max(off_straight(view, all_dockable) for view in all_dockable.scene.viewpoints) < 15.001
    assert sum(off_straight(view, before) < 15.0 for view in before.scene.viewpoints) <= 3


def test_nothing_but_the_views_changes(before: SampledScene, all_dockable: SampledScene) -> None:
    assert len(before.scene.viewpoints) == len(all_dockable.scene.viewpoints)
    for one, other in zip(before.scene.instances, all_dockable.scene.instances, strict=True):
        assert np.array_equal(one.T_world_object, other.T_world_object)


def test_headings_go_into_free_faces_alone(before: SampledScene) -> None:
    headings = dockable_headings(before.scene, TRUCKS[before.settings.layout.truck])
    assert headings
    for entry in entries_of(before.scene):
        if entry.target.instance_id in headings:
            ahead = entry.T_world_entry[:2, 0]
            middle = entry.target.T_world_object[:2, 3] - entry.T_world_entry[:2, 3]
            assert ahead @ middle > 0.0  # from the face to the middle of the pallet


def test_half_of_the_views_are_replaced(before: SampledScene) -> None:
    half = sample_settled_scene(recipe(0.5), 4711, 1).scene.viewpoints
    kept = sum(
        np.array_equal(one.T_world_camera, other.T_world_camera)
        for one, other in zip(before.scene.viewpoints, half, strict=True)
    )
    assert kept == 4


def test_what_no_truck_looks_from_has_no_such_views() -> None:
    views = load_recipe("overhead").scene.viewpoints
    with pytest.raises(ConfigError, match="leave dockable_fraction out, or the kind"):
        replace(views, kind="free", dockable_fraction=0.5)


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
