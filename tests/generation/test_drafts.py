"""What scenes of every shipped recipe keep to as soon as they are drafted."""

from dataclasses import dataclass

import numpy as np
import pytest

from tests.generation.test_closed_halls import lost
from warehouse_sim.generation.plan import target_models
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.resources import recipe_names
from warehouse_sim.scene import sample_scene
from warehouse_sim.schema import SceneSpec

SAME_HALLS = {"mixed_cartons", "mixed_more", "photoreal", "unknown_pallets", "wide_angle"}
"""Recipes with the halls of the one that they extend; their kinds of targets, too, another recipe has."""


@dataclass(frozen=True)
class Draft:
    """A scene that was sampled from a recipe, but not settled."""

    recipe: Recipe
    scene: SceneSpec


def drafts() -> list[object]:
    """Return name and scene of each draft: the first of each recipe, and, where there is time, one much later."""
    return [
        pytest.param((name, index), id=f"{name}-{index}", marks=[pytest.mark.slow] * (index > 0 or name in SAME_HALLS))
        for name in recipe_names()
        for index in (0, 23)
    ]


@pytest.fixture(scope="module", params=drafts())
def draft(request: pytest.FixtureRequest) -> Draft:
    name, index = request.param
    recipe = load_recipe(name)
    return Draft(recipe, sample_scene(recipe.scene, seed=0, scene_index=index))


def test_every_pixel_looks_at_a_surface(draft: Draft) -> None:
    rays = draft.recipe.sensors.make_camera().rays()[::7, ::7].reshape(-1, 3)
    caster = RayCaster(draft.scene)
    for view in draft.scene.viewpoints:
        T = view.T_world_camera
        eye = np.broadcast_to(T[:3, 3], rays.shape)
        assert lost(caster, eye, eye + rays @ T[:3, :3].T) == 0


def test_every_target_that_is_placed_is_among_the_recipes_models(draft: Draft) -> None:
    known = {model.obj_id for model in target_models(draft.recipe)}
    placed = {draft.scene.model_of(instance).obj_id for instance in draft.scene.target_instances()}
    assert placed
    assert placed <= known
