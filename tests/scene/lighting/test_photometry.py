from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.scene import Distribution, SceneRecipe, sample_scene
from warehouse_sim.scene.lighting.config import PRESETS, LightingConfig
from warehouse_sim.scene.lighting.photometry import (
    cone_of_beam,
    floor_points,
    flux_per_candela,
    light_illuminance,
    luminous_flux,
    relative_intensity,
    unshadowed_illuminance,
)
from warehouse_sim.schema import Light

UP, DOWN = np.array([[0.0, 0.0, 1.0]]), np.array([0.0, 0.0, -1.0])


def light(**settings: object) -> Light:
    defaults = {"kind": "point", "position": np.array([0.0, 0.0, 5.0]), "direction": DOWN, "intensity": 1000.0}
    return Light(**(defaults | settings))  # type: ignore[arg-type]


def at(*place: float) -> np.ndarray:
    return np.array([place])


def test_illuminance_follows_the_inverse_square_and_the_cosine() -> None:
    assert light_illuminance(light(), at(0, 0, 0), UP) == pytest.approx(1000 / 25)
    assert light_illuminance(light(), at(5, 0, 0), UP) == pytest.approx(1000 * np.cos(np.pi / 4) ** 3 / 25)
    assert light_illuminance(light(), at(0, 0, 0), -UP) == 0.0
    assert unshadowed_illuminance([light(), light()], at(0, 0, 0), UP) == pytest.approx(80.0)
    assert unshadowed_illuminance([], at(0, 0, 0), UP) == 0.0


def test_a_spot_is_full_inside_dark_outside_and_falls_as_gltf_says_between() -> None:
    spot = light(kind="spot", position=np.array([0.0, 0.0, 1.0]), intensity=100.0, cone_inner=0.5, cone_outer=1.0)

    def floor(angle: float) -> float:
        return float(light_illuminance(spot, at(np.tan(angle), 0, 0), UP)[0]) / np.cos(angle) ** 3

    assert floor(0.49) == pytest.approx(100.0)
    fraction = (np.cos(0.8) - np.cos(1.0)) / (np.cos(0.5) - np.cos(1.0))
    assert floor(0.8) == pytest.approx(100.0 * fraction**2)
    assert floor(1.01) == 0.0


@pytest.mark.parametrize("beam_deg", [10.0, 40.0, 70.0, 90.0, 110.0, 130.0, 150.0])
def test_flux_over_the_sphere_is_the_lumens_and_the_beam_ends_at_half_intensity(beam_deg: float) -> None:
    inner, outer = cone_of_beam(beam_deg)
    assert 0.0 <= inner < outer < np.pi / 2
    spot = light(kind="spot", cone_inner=inner, cone_outer=outer, intensity=15000.0 / flux_per_candela(inner, outer))
    half = relative_intensity(spot, np.array([1.0, np.cos(np.deg2rad(beam_deg) / 2)]), np.zeros((2, 3)))
    np.testing.assert_allclose(half, [1.0, 0.5], atol=0.02)
    # Rings of the sphere, each of solid angle 2 pi d(cos).
    cosine = np.linspace(-1.0, 1.0, 200001)
    middle = (cosine[1:] + cosine[:-1]) / 2
    fraction = relative_intensity(spot, middle, np.zeros((len(middle), 3)))
    flux = 2 * np.pi * np.sum(spot.intensity * fraction) * (cosine[1] - cosine[0])
    assert flux == pytest.approx(15000.0, rel=0.01)
    assert luminous_flux(spot) == pytest.approx(15000.0)


def test_a_point_light_sends_its_candelas_everywhere() -> None:
    assert luminous_flux(light(intensity=10.0)) == pytest.approx(40 * np.pi)


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
