"""The backends that know textures only lay the same picture as the raster backend does."""

from typing import Any

import numpy as np
import pytest
import zxingcpp

from warehouse_sim.catalog.parts import box_part
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z
from warehouse_sim.render import open_renderer
from warehouse_sim.render.conformance.scenes import make_scene
from warehouse_sim.render.textures import picture_coordinates
from warehouse_sim.schema import Material, ObjectModel

LABEL = Material("label", (0.8, 0.8, 0.78), roughness=1.0, picture="shipping_label:7")


@pytest.mark.parametrize(("backend", "options"), [("pathtrace", {"samples": 16}), ("pyrender", {}), ("mujoco", {})])
@pytest.mark.parametrize("turn", [0.0, np.pi])
@pytest.mark.gl
def test_a_label_is_read_from_both_sides(backend: str, options: dict[str, Any], turn: float) -> None:
    part = box_part((0.0004, 0.148, 0.105), (0.0, 0.0, 0.0), "label")
    model = ObjectModel("sheet", "carton", 999, part.scale, (part,), (), materials=(LABEL,))
    scene = make_scene([model], [("sheet", make_transform(rotation_z(turn), np.zeros(3)))], [], ambient=300.0)
    scene.materials["label"] = LABEL
    with open_renderer(backend, **options) as renderer:
        renderer.load(scene)
        view = level_camera(np.array([-1.0, 0.0, 0.0]), 0.0, 0.0)
        rgb = renderer.render(PinholeCamera.from_focal(640, 480, 2400.0), view).rgb
    codes = [code for code in zxingcpp.read_barcodes(rgb, try_rotate=False) if abs(code.orientation) < 45]
    assert {code.text.strip("()")[:2] for code in codes} == {"00"}


def test_edges_show_the_corner() -> None:
    metres = np.array([[0.0, 0.0, 0.0], [0.0, 0.2, 0.1], [0.001, 0.2, 0.1]])
    laid = picture_coordinates(metres, np.array([[1.0, 0, 0], [1.0, 0, 0], [0, 0, 1.0]]))
    np.testing.assert_allclose(laid[:2], [[0.0, 1.0], [1.0, 0.0]])
    assert (laid[2] < 0.01).all()
