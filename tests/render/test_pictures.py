"""Pictures lie upright and unmirrored on the faces of thin parts, and are filtered when they are small."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import zxingcpp

from warehouse_sim.catalog.parts import box_part
from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_x, rotation_z
from warehouse_sim.render import Renderer, open_renderer
from warehouse_sim.render.conformance.scenes import MATERIALS, box_model, make_scene
from warehouse_sim.render.raster import surfaces
from warehouse_sim.render.raster.context import open_context
from warehouse_sim.render.textures import picture_coordinates
from warehouse_sim.schema import Material, ObjectModel, SceneSpec

LABEL = Material("label", (0.8, 0.8, 0.78), roughness=1.0, picture="shipping_label:7")
SHEETS = {"x": (0.0004, 0.148, 0.105), "y": (0.148, 0.0004, 0.105)}
AHEAD = level_camera(np.array([-1.0, 0.0, 0.0]), 0.0, 0.0)
"""A metre before the origin, looking along +x."""


def scene_of(size: tuple[float, float, float], T: np.ndarray, paint: Material = LABEL) -> SceneSpec:
    """Return one thin box in even light."""
    scene = make_scene([box_model("sheet", size, paint.name)], [("sheet", T)], [], ambient=300.0, exposure=0.01)
    return replace(scene, materials={**MATERIALS, paint.name: paint})


def texts(renderer: Renderer, scene: SceneSpec, focal: float = 1600.0) -> set[str]:
    """Return what a decoder reads in the view from a metre away; it reads no mirrored code."""
    renderer.load(scene)
    rgb = renderer.render(PinholeCamera.from_focal(640, 480, focal), AHEAD).rgb
    codes = zxingcpp.read_barcodes(rgb, try_rotate=False)
    return {code.text.replace("(", "").replace(")", "") for code in codes if code.orientation in range(-45, 46)}


@pytest.mark.gl
@pytest.mark.parametrize("turn", [0, 2])
@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_label_is_read_a_metre_away_from_both_sides(renderer: Renderer, axis: str, turn: int) -> None:
    quarter = turn + (1 if axis == "y" else 0)
    found = texts(renderer, scene_of(SHEETS[axis], make_transform(rotation_z(quarter * np.pi / 2), np.zeros(3))))
    assert len(found) == 1
    assert next(iter(found)).startswith("00")


@pytest.mark.gl
def test_a_lying_sheet_is_upright_along_its_y(renderer: Renderer) -> None:
    """Set up so that its y looks up and its top to the camera."""
    stand = rotation_z(-np.pi / 2) @ rotation_x(np.pi / 2)
    assert texts(renderer, scene_of((0.148, 0.105, 0.0004), make_transform(stand, np.zeros(3))))


@pytest.mark.gl
def test_a_far_label_has_the_mean_light_of_its_picture(renderer: Renderer) -> None:
    """A module of the code is a tenth of a pixel here: whatever part of it a pixel meets, it shows the mean."""
    camera = PinholeCamera.from_focal(640, 480, 80.0)
    greys = []
    for shift in np.linspace(0.0, 0.012, 5):
        scene = scene_of((0.0004, 0.296, 0.21), make_transform(None, np.array([0.0, shift, 0.0])))
        renderer.load(scene)
        buffers = renderer.render(camera, AHEAD)
        rows, columns = np.nonzero(buffers.instance_mask == 1)
        inside = (np.abs(rows - rows.mean()) < 5) & (np.abs(columns - columns.mean()) < 8)
        greys.append(buffers.rgb[rows[inside], columns[inside]].astype(float).mean())
    assert np.std(greys) < 2.0


@pytest.mark.gl
def test_ink_leaves_the_board_as_it_is(renderer: Renderer) -> None:
    """Where a print covers nothing, the pixels are those of the same part without one."""
    plain = Material("board", (0.44, 0.3, 0.175), 0.85)
    views = []
    for paint in (plain, replace(plain, picture="carton_print:3")):
        renderer.load(scene_of(SHEETS["x"], make_transform(), paint))
        views.append(renderer.render(PinholeCamera.from_focal(640, 480, 1600.0), AHEAD).rgb.astype(int))
    change = np.abs(views[0] - views[1]).max(axis=-1)
    assert 0.9 < (change <= 1).mean() < 0.99


@pytest.mark.gl
def test_a_scene_holds_four_thousand_materials(renderer: Renderer) -> None:
    """The last ones keep their colour: red in the eleventh bit of the row, blue in the twelfth."""
    filler = {f"grey{i}": Material(f"grey{i}", (0.2, 0.2, 0.2)) for i in range(4094)}
    for at, colour in ((1500, (0.8, 0.0, 0.0)), (4093, (0.0, 0.0, 0.8))):
        name = f"grey{at}"
        scene = scene_of(SHEETS["x"], make_transform(), Material(name, colour, 1.0))
        renderer.load(replace(scene, materials={**filler, name: Material(name, colour, 1.0)}))
        middle = renderer.render(PinholeCamera.from_focal(640, 480, 1600.0), AHEAD).rgb[240, 320].astype(int)
        assert middle.argmax() == int(np.argmax(colour))
        assert middle.max() > 3 * np.sort(middle)[1]
    too_many = {f"m{i}": Material(f"m{i}", (0.2, 0.2, 0.2)) for i in range(4097)}
    with pytest.raises(RenderError, match="at most 4096"):
        renderer.load(replace(scene, materials={**too_many, **scene.materials}))


# The backends that know textures only lay the same picture as the raster backend does.


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


@pytest.mark.gl
def test_a_picture_is_drawn_once_however_often_new_ones_come(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[str] = []
    texels = surfaces._texels
    monkeypatch.setattr(surfaces, "_texels", lambda name: drawn.append(name) or texels(name))
    with open_context() as context:
        library = surfaces.PictureLibrary(context)
        library.require(["shipping_label:0"])
        layers = library.require(["shipping_label:0", "shipping_label:1"])
        assert layers == {"shipping_label:0": 0, "shipping_label:1": 1}
    assert drawn == ["shipping_label:0", "shipping_label:1"]
