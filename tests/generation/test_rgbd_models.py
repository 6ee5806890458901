"""Recipes name depth and colour cameras, and observations are read through them."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from warehouse_sim.config import from_mapping
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.recipe.paired_variants import base_variant
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.render import Renderer
from warehouse_sim.schema import Observation
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.sensors.rig import SensorChoice

pytestmark = pytest.mark.gl


@pytest.fixture(scope="module")
def observed(renderer: Renderer) -> Callable[[dict[str, Any]], Observation]:
    """Return what gives the first observation of the smoke recipe, read with other settings of the RGB-D camera."""
    recipe = load_recipe("smoke")
    scene = sample_settled_scene(recipe, 0, 0).scene
    scene = replace(scene, viewpoints=scene.viewpoints[:1])

    def observe(plain: dict[str, Any]) -> Observation:
        variant = base_variant(scene, SensorChoice("", from_mapping(RgbdConfig, plain, "sensors: rgbd")))
        return next(observe_scene(scene, recipe.sensors, renderer, (variant,)))

    return observe


def test_the_same_seed_gives_the_same_bytes_and_sensors_do_not_disturb_each_other(
    observed: Callable[[dict[str, Any]], Observation],
) -> None:
    plain = observed({})
    stereo, again = (observed({"depth": {"preset": "d435", "max_range": 30.0}}) for _ in range(2))
    assert np.array_equal(stereo.rgbd.depth, again.rgbd.depth)
    assert np.array_equal(stereo.rgbd.rgb, again.rgbd.rgb)
    assert np.array_equal(stereo.rgbd.rgb, plain.rgbd.rgb)
    assert np.array_equal(stereo.buffers.depth, plain.buffers.depth)
    assert stereo.lidar is not None
    assert plain.lidar is not None
    assert np.array_equal(stereo.lidar.points, plain.lidar.points)
    clean = observed({"color": "ideal"})
    assert np.array_equal(clean.rgbd.depth, plain.rgbd.depth)
    assert np.array_equal(clean.rgbd.rgb, plain.buffers.rgb)


@pytest.mark.parametrize("preset", ["kinect_v1", "d435", "flexx2"])
def test_a_real_camera_has_holes_where_the_ground_truth_has_none(
    observed: Callable[[dict[str, Any]], Observation], preset: str
) -> None:
    observation = observed({"depth": {"preset": preset, "max_range": 12.0}})
    true, read = observation.buffers.depth, observation.rgbd.depth
    in_range = (true > 0.8) & (true < 12.0)
    fraction = (read > 0)[in_range].mean()
    assert 0.2 < fraction < 0.999
    for label in observation.annotations:
        assert label.pixels_valid <= label.pixels_visible
