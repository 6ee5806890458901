"""Light by way of a smooth floor, in closed form."""

import numpy as np
import pytest

from tests.sensors.targets import CAMERA
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import Material
from warehouse_sim.sensors.surfaces import Reflected, see_surfaces

HEIGHT, WALL = 0.2, 2.0
MATERIALS = {
    "mirror": Material("mirror", (0.2,) * 3, roughness=0.05, remission=0.3),
    "matt": Material("matt", (0.2,) * 3, roughness=0.9, remission=0.3),
}


def reflected(floor: str) -> Reflected:
    """A camera 20 cm above a floor, 2 m before a wall."""
    models = [box_model("floor", (20, 20, 0.1), floor), box_model("wall", (8, 0.2, 4), "matt")]
    scene = make_scene(models, [("floor", at(0, 0, -0.05)), ("wall", at(0, WALL + 0.1, 2.0))], materials=MATERIALS)
    place = level_camera(np.array([0.0, 0.0, HEIGHT]), np.pi / 2)
    found = see_surfaces(scene, RayCaster(scene), CAMERA, place, reflections=True).reflected
    assert found is not None
    return found


def test_a_smooth_floor_shows_the_mirrored_wall_at_its_range() -> None:
    found = reflected("mirror")
    for row in (180, 200, 220):
        down = (row - CAMERA.cy) / CAMERA.fy
        column = 160
        slope = np.hypot(down, (column - CAMERA.cx) / CAMERA.fx)
        over = WALL * np.sqrt(1 + slope**2)
        height = abs(HEIGHT - WALL * down)  # where the mirrored ray meets the wall
        direct = np.sqrt(WALL**2 + (height - HEIGHT) ** 2)
        cosine = down / np.sqrt(1 + slope**2)
        thrown = (0.04 + 0.96 * (1 - cosine) ** 5) * np.exp(-((0.05 / 0.35) ** 4))
        there, straight = thrown * (WALL / over) / over**2, (WALL / direct) / direct**2
        assert found.light[row, column] == pytest.approx(thrown * 0.3 * (there + straight), rel=0.02)
        expected = (there * over + straight * (over + direct) / 2) / (there + straight)
        assert found.ranges[row, column] == pytest.approx(expected, rel=2e-3)
        assert found.kept[row, column] == pytest.approx((1 - thrown) ** 2, rel=0.02)


def test_matt_surfaces_throw_nothing_on() -> None:
    found = reflected("matt")
    assert (found.light == 0).all()
    assert found.kept.min() > 0.95
