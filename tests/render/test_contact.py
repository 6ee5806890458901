"""The floor is dark beside what stands on it, as far as on photographs; and the measure finds what is there."""

import numpy as np
import pytest

from tests.render.contact import contacts, contacts_of_scene, summary
from tests.stored import held
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import open_renderer
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene, pallet_model, spot
from warehouse_sim.schema import SceneSpec

CAMERA = PinholeCamera.from_focal(1280, 720, 920.0)
FLOOR = box_model("floor", (60, 40, 0.1), "concrete", "floor", 90)
LOAD = box_model("load", (1.2, 0.8, 1.0))
CARTON = box_model("carton", (0.6, 0.4, 0.4))


def hall() -> SceneSpec:
    """Return 16 loaded pallets and 16 cartons under six lamps."""
    placed = [("floor", at(0, 0, -0.05))]
    for row in range(4):
        for column in range(4):
            x, y, yaw = 4.5 + 3.2 * row, 3.0 * (column - 1.5), 0.3 * column
            placed += [("pallet", at(x, y, 0.072, yaw)), ("load", at(x, y, 0.644, yaw))]
            placed.append(("carton", at(x - 1.6, y + 1.5, 0.2, 0.7 - yaw)))
    lights = [spot((x, y, 7.0), 3000.0) for x in (2.0, 7.0, 12.0) for y in (-4.0, 4.0)]
    T_world_camera = level_camera(np.array([0.0, 0.0, 3.5]), 0.0, -0.3)
    return make_scene([FLOOR, LOAD, CARTON, pallet_model()], placed, lights, [T_world_camera], ambient=60.0)


@pytest.mark.gl
def test_the_floor_is_darker_beside_a_foot_and_as_around_soon() -> None:
    scene = hall()
    view = scene.viewpoints[0].T_world_camera
    with open_renderer() as renderer:
        renderer.load(scene)
        found = summary(contacts(renderer.render(CAMERA, view), CAMERA, view, scene))
    assert found["n"] >= 20
    assert 0.4 < found["value"] < 0.65
    assert found["quartile_3"] < 0.8
    assert 0.15 <= found["back"] <= 0.4


@pytest.mark.gl
def test_an_evenly_lit_floor_has_no_rim() -> None:
    scene = hall()
    view = scene.viewpoints[0].T_world_camera
    with open_renderer() as renderer:
        renderer.load(scene)
        buffers = renderer.render(CAMERA, view)
    buffers.rgb[:] = 128
    found = summary(contacts(buffers, CAMERA, view, scene))
    assert found["value"] == pytest.approx(1.0)
    assert found["back"] < 0.05


@pytest.mark.slow
@pytest.mark.gl
@pytest.mark.parametrize("recipe", ["dock_staging", "block_storage", "selective_rack"])
def test_floors_of_recipes_are_as_dark_as_is_stored(recipe: str) -> None:
    found = summary([contact for index in range(2) for contact in contacts_of_scene(recipe, index)])
    stored = held("contact", __file__, [{"name": recipe, **found}])[recipe]
    assert found["value"] == pytest.approx(stored["value"], abs=0.03)
    assert found["back"] == pytest.approx(stored["back"], abs=0.05)
