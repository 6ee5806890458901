from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.scene import Distribution, SceneRecipe, sample_scene
from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.lighting.photometry import floor_points, unshadowed_illuminance
from warehouse_sim.scene.lighting.presets import PRESETS


@pytest.mark.parametrize("preset", PRESETS)
def test_a_scene_that_is_just_drawn_has_the_wanted_lux_where_nothing_throws_a_shadow(preset: str) -> None:
    config = LightingConfig(preset=preset, lux=Distribution.constant(123.0))  # type: ignore[arg-type]
    scene = sample_scene(SceneRecipe(lights=config), 0, 1)
    floor = floor_points(scene)
    up = np.tile([0.0, 0.0, 1.0], (len(floor), 1))
    assert unshadowed_illuminance(scene.lights, floor, up).mean() + scene.ambient == pytest.approx(123.0)
    assert scene.lighting == preset
    assert scene.exposure > 0.0


def test_floor_points_fill_the_aisle() -> None:
    scene = sample_scene(SceneRecipe(), 0, 0)
    assert scene.aisle is not None
    x_min, x_max, y_min, y_max = scene.aisle
    points = floor_points(scene)
    assert len({tuple(row) for row in points.tolist()}) == len(points) >= 48
    assert x_min < points[:, 0].min() < x_min + 1.5
    assert y_max - 1.5 < points[:, 1].max() < y_max
    np.testing.assert_allclose(points[:, :2].mean(axis=0), [(x_min + x_max) / 2, (y_min + y_max) / 2], atol=1e-12)
    with pytest.raises(ValueError, match=r"set SceneSpec\.aisle"):
        floor_points(replace(scene, aisle=None))
