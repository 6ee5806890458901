"""Most of the cast of the light in view is taken away, its luminance is not, and the colours of things stay."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import capture_of
from warehouse_sim.color import LUMINANCE, balanced_rgb
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.display import to_display
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import RenderBuffers, SceneSpec
from warehouse_sim.sensors.rgbd.color import IDEAL_COLOR, read_color
from warehouse_sim.sensors.white_balance import balancing, light_color

CAMERA = PinholeCamera.from_focal(160, 120, 100.0)
WARM, COLD = balanced_rgb(2800.0, 4700.0), balanced_rgb(6400.0, 4700.0)


def wall(material: str) -> SceneSpec:
    """Return a wall before the camera."""
    return make_scene([box_model("wall", (0.2, 20.0, 20.0), material)], [("wall", at(4.0, 0.0, 0.0))])


def shown(scene: SceneSpec, material: str, light: tuple[float, float, float]) -> np.ndarray:
    linear = 0.5 * np.array(scene.materials[material].base_color) * light
    return np.tile(to_display(linear[None, None]), (CAMERA.height, CAMERA.width, 1))


@pytest.mark.parametrize("material", ["concrete", "kraft", "wood"])
@pytest.mark.parametrize("light", [WARM, COLD, (1.0, 1.0, 1.0)])
def test_the_colour_of_the_light_is_found_on_grey_and_on_brown(
    material: str, light: tuple[float, float, float]
) -> None:
    scene, T_world_camera = wall(material), level_camera(np.array([0.0, 0.0, 1.0]), 0.0)
    found = light_color(scene, RayCaster(scene), CAMERA, T_world_camera, shown(scene, material, light))
    np.testing.assert_allclose(found, light, rtol=0.05)


def test_what_is_black_white_or_nothing_tells_nothing() -> None:
    scene, T_world_camera = wall("concrete"), level_camera(np.array([0.0, 0.0, 1.0]), 0.0)
    black = np.zeros((CAMERA.height, CAMERA.width, 3), np.uint8)
    caster = RayCaster(scene)
    for rgb, view in ((black, T_world_camera), (black + 255, T_world_camera)):
        assert light_color(scene, caster, CAMERA, view, rgb) == (1.0, 1.0, 1.0)
    away = level_camera(np.array([0.0, 0.0, 1.0]), np.pi)
    assert light_color(scene, caster, CAMERA, away, shown(scene, "concrete", WARM)) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize("light", [WARM, COLD])
def test_gains_take_their_fraction_of_the_cast_and_keep_the_luminance(light: tuple[float, float, float]) -> None:
    left = np.array(light) * balancing(light, 0.8)
    assert float(LUMINANCE @ left) == pytest.approx(float(LUMINANCE @ np.array(light)))
    before, after = (np.log(np.array(color)[[0, 2]] / color[1]) for color in (light, left))
    np.testing.assert_allclose(after, 0.2 * before)
    assert (balancing((1.0, 1.0, 1.0), 0.8) == 1.0).all()


def test_a_grey_wall_in_warm_light_is_nearly_grey() -> None:
    config = replace(IDEAL_COLOR, auto_white_balance=0.8)
    rgb = np.full((40, 60, 3), 0, np.uint8)
    rgb[:] = np.rint(100.0 * np.array(WARM) ** (1 / 2.2))
    buffers = RenderBuffers(rgb, np.ones((40, 60), np.float32), np.zeros((40, 60), np.int32))
    capture = replace(capture_of(PinholeCamera.from_focal(60, 40, 50.0)), light=WARM)
    stored = read_color(buffers, capture, config, np.random.default_rng(0)).mean(axis=(0, 1))
    assert np.ptp(stored) < 0.3 * np.ptp(rgb[0, 0].astype(float))
