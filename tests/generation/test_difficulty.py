"""The dial moves what is measured, and moves it one way."""

import numpy as np
import pytest

from warehouse_sim.errors import RecipeError
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.recipe.difficulty import EASY_TO_HARD, with_difficulty
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.render import open_renderer


def test_every_setting_of_the_table_moves_and_all_else_stays() -> None:
    recipe = load_recipe("industrial")
    easy, hard = with_difficulty(recipe, 0.0), with_difficulty(recipe, 1.0)
    for moved, end in ((easy, 0), (hard, 1)):
        assert moved.scene.traffic.people.low == EASY_TO_HARD["scene.traffic.people"][end]
        assert moved.scene.lights.lux is not None
        assert moved.scene.lights.lux.low == pytest.approx(EASY_TO_HARD["scene.lights.lux"][end])
        assert moved.sensors.rgbd.depth.noise_scale == EASY_TO_HARD["sensors.rgbd.depth.noise_scale"][end]
        assert moved.sensors.rgbd.color.noise_scale == pytest.approx(
            EASY_TO_HARD["sensors.rgbd.color.noise_scale"][end]
        )
        assert moved.occlusion is not None
        (requested,) = moved.occlusion.visible_fraction.ranges
        assert (requested.min, requested.max) == pytest.approx(
            [EASY_TO_HARD[f"occlusion.visible_fraction.{name}"][end] for name in ("min", "max")]
        )
        assert moved.scene.layout == recipe.scene.layout
        assert moved.scene.viewpoints == recipe.scene.viewpoints
        assert moved.sensors.lidar == recipe.sensors.lidar


@pytest.mark.parametrize("difficulty", [-0.1, 1.1, float("nan")])
def test_only_0_to_1_is_taken(difficulty: float) -> None:
    with pytest.raises(RecipeError, match="difficulty must be 0-1"):
        with_difficulty(load_recipe("smoke"), difficulty)


@pytest.mark.gl
@pytest.mark.slow
def test_measured_clutter_occlusion_light_and_noise_rise_with_the_dial() -> None:
    statistics = []
    with open_renderer() as renderer:
        for difficulty in (0.0, 0.5, 1.0):
            recipe = with_difficulty(load_recipe("industrial"), difficulty)
            objects, visible, lux, error = [], [], [], []
            for index in range(4):
                prepared = prepare_scene(recipe, 0, index)
                assert prepared.occlusion is not None
                objects.append(len(prepared.scene.instances))
                visible += [item.reached for item in prepared.occlusion.requests if item.met]
                for observation in observe_scene(prepared.scene, recipe.sensors, renderer, prepared.variants):
                    lux.append(observation.conditions.floor_lux)
                    read, true = observation.rgbd.depth, observation.buffers.depth
                    near = (read > 0) & (true < 8.0)
                    error.append(np.std((read - true)[near]))
            statistics.append([np.mean(objects), -np.mean(visible), -np.mean(lux), np.mean(error)])
    assert (np.diff(statistics, axis=0) > 0).all(), statistics
