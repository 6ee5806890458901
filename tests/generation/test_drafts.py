"""What scenes of every shipped recipe keep to as soon as they are drafted."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from tests.generation.test_closed_halls import eyes, lost
from warehouse_sim.generation.plan import target_models
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.resources import recipe_names
from warehouse_sim.scene import sample_scene
from warehouse_sim.schema import SceneSpec
from warehouse_sim.sensors.lidar import scan
from warehouse_sim.sensors.rig import RigConfig

SAME_HALLS = {
    "industrial-v1",
    "industrial_cartons",
    "industrial_more",
    "mixed_cartons",
    "mixed_more",
    "photoreal",
    "unknown_pallets",
    "wide_angle",
}
"""Recipes with the halls of the one that they extend or grew from; their kinds of targets, too, another recipe has."""
SHORT = {
    "drive_in": {"lanes": 4, "lane_depth": 3},
    "very_narrow_aisle": {"bays": 2, "levels": 4},
}
"""Fewer bays and lanes of the recipes whose racks take long to fill; the later scene has all."""
# As in tests/sensors/lidar/test_published.py, which does the same in streets.
KITTI_POINTS = 120_000


@dataclass(frozen=True)
class Draft:
    """A scene that was sampled from a recipe, but not settled."""

    recipe: Recipe
    scene: SceneSpec
    caster: RayCaster


@cache
def draft_of(name: str, index: int) -> Draft:
    recipe = load_recipe(name, {"scene": {"layout": SHORT[name]}} if name in SHORT and index == 0 else None)
    few = replace(recipe.scene, observations_per_scene=min(3, recipe.scene.observations_per_scene))
    scene = sample_scene(few, seed=0, scene_index=index)
    return Draft(recipe, scene, RayCaster(scene))


def drafts() -> list[object]:
    """Return name and scene of each draft: the first of each recipe, and, where there is time, one much later."""
    return [
        pytest.param((name, index), id=f"{name}-{index}", marks=[pytest.mark.slow] * (index > 0 or name in SAME_HALLS))
        for name in recipe_names()
        for index in (0, 23)
    ]


@pytest.fixture(params=drafts())
def draft(request: pytest.FixtureRequest) -> Draft:
    return draft_of(*request.param)


def test_every_pixel_looks_at_a_surface(draft: Draft) -> None:
    rays = draft.recipe.sensors.make_camera().rays()[::7, ::7].reshape(-1, 3)
    for view in draft.scene.viewpoints:
        T = view.T_world_camera
        eye = np.broadcast_to(T[:3, 3], rays.shape)
        assert lost(draft.caster, eye, eye + rays @ T[:3, :3].T) == 0


def test_every_target_that_is_placed_is_among_the_recipes_models(draft: Draft) -> None:
    known = {model.obj_id for model in target_models(draft.recipe)}
    placed = {draft.scene.model_of(instance).obj_id for instance in draft.scene.target_instances()}
    assert placed
    assert placed <= known


@pytest.mark.parametrize("name", ["selective_rack", "dock_staging"])
def test_nothing_is_to_be_seen_between_walls_and_roof(name: str) -> None:
    draft, rng = draft_of(name, 0), np.random.default_rng(0)
    angles = rng.uniform(0.0, 2 * np.pi, 200_000)
    around = 23.9 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    heights = rng.uniform(8.8, 9.3, len(angles))
    targets = np.column_stack([around * np.cos(angles), around * np.sin(angles), heights])
    assert lost(draft.caster, eyes(draft.scene, len(targets), rng), targets) == 0


@pytest.mark.parametrize("name", ["industrial", "dock_staging", "block_storage", "selective_rack"])
def test_a_sweep_in_a_hall_has_within_15_percent_of_the_points_of_kittis(name: str) -> None:
    rig = RigConfig.from_plain({"rig": "kitti"}, "here")
    assert rig.lidar is not None
    caster = draft_of(name, 0).caster
    for number, viewpoint in enumerate(draft_of(name, 0).scene.viewpoints[:3]):
        T_world_lidar = viewpoint.T_world_camera @ rig.mounted()["lidar"].T_camera_sensor(viewpoint)
        points = scan(caster, rig.lidar, T_world_lidar, np.random.default_rng(number)).points
        # Walls and a roof close the view, so that nearly every one of the 133,312 pulses comes back.
        # But for those that end within the least range of the sensor, where racks stand beside a narrow aisle.
        eager = replace(rig.lidar, min_range=0.0)
        too_near = scan(caster, eager, T_world_lidar, np.random.default_rng(number)).points
        near = int((np.linalg.norm(too_near, axis=1) < rig.lidar.min_range).sum())
        assert 1.05 * KITTI_POINTS < len(points) + near < 1.15 * KITTI_POINTS
