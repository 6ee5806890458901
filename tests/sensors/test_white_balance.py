"""Most of the cast of the light in view is taken away, its luminance is not, and only what is lit counts."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import capture_of
from warehouse_sim.color import LUMINANCE, balanced_rgb
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene, spot
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import RenderBuffers, SceneSpec
from warehouse_sim.sensors.rgbd.color import IDEAL_COLOR, read_color
from warehouse_sim.sensors.white_balance import balancing, light_color

CAMERA = PinholeCamera.from_focal(160, 120, 100.0)
WARM, COLD = balanced_rgb(2800.0, 4700.0), balanced_rgb(6400.0, 4700.0)


def wall(ambient: float = 0.0) -> SceneSpec:
    """Return a wall before the camera, a warm lamp beside that and a brighter cold one behind the wall."""
    models = [box_model("wall", (0.2, 20.0, 20.0))]
    lights = [
        replace(spot((0.0, 2.0, 1.0), 500.0), direction=np.array([1.0, 0.0, 0.0]), color=WARM),
        replace(spot((6.0, 0.0, 1.0), 9000.0), direction=np.array([-1.0, 0.0, 0.0]), color=COLD),
    ]
    return make_scene(models, [("wall", at(4.0, 0.0, 0.0))], lights, ambient=ambient)


def color_of(scene: SceneSpec) -> tuple[float, float, float]:
    T_world_camera = level_camera(np.array([0.0, 0.0, 1.0]), 0.0)
    depth = np.full((CAMERA.height, CAMERA.width), 3.9, np.float32)
    return light_color(scene, RayCaster(scene), CAMERA, T_world_camera, depth)


def test_the_lamp_that_lights_what_is_seen_gives_its_colour() -> None:
    assert color_of(wall()) == pytest.approx(WARM)
    assert color_of(replace(wall(), lights=())) == (1.0, 1.0, 1.0)


def test_the_even_light_is_white_and_counts() -> None:
    mixed = color_of(wall(ambient=50.0))
    assert WARM[0] > mixed[0] > 1.0
    assert float(LUMINANCE @ mixed) == pytest.approx(1.0)


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
