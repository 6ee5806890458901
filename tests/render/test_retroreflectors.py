"""Bands of vests in colour images: bright in work lights beside the lens, grey in all other light."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import open_renderer
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.schema import Light, Material

BOARD = box_model("board", (2.0, 0.02, 2.0), "concrete", "rack", 90)
CAMERA = PinholeCamera.from_focal(32, 32, 300.0)


def brightness(remission: float, light: Light) -> np.ndarray:
    """Return the image of a grey board 8 m before the camera."""
    paint = {**MATERIALS, "concrete": Material("concrete", (0.62,) * 3, roughness=0.9, remission=remission)}
    scene = make_scene([BOARD], [("board", at(0, 8.0, 1.0))], [light], materials=paint, ambient=0.0, exposure=0.01)
    with open_renderer("raster") as renderer:
        renderer.load(scene)
        return renderer.render(CAMERA, level_camera(np.array([0.0, 0.0, 1.0]), np.pi / 2)).rgb.astype(int)


def lamp(x: float, y: float = 0.0) -> Light:
    towards = np.array([-x, 8.0 - y, 0.0])
    return replace(spot((x, y, 1.0), 500.0), direction=towards / np.linalg.norm(towards), radius=0.05)


@pytest.mark.gl
def test_a_work_light_beside_the_lens_makes_a_band_brighter_than_white() -> None:
    band, paint = (brightness(remission, lamp(0.5)).mean() for remission in (2.0, 0.9))
    assert band > 1.5 * paint
    assert brightness(2.0, lamp(0.1)).mean() > band


@pytest.mark.gl
def test_any_other_light_leaves_every_byte_as_it_was() -> None:
    for light in (lamp(5.0), lamp(0.0, 4.5)):
        assert (brightness(2.0, light) == brightness(0.9, light)).all()
        assert brightness(2.0, light).max() > 10
