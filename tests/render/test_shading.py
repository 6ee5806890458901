"""Light does what physics says, as far as eight bits after a tone curve can show it."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.render.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.render.raster import materials
from warehouse_sim.schema import Light, Material, SceneSpec

pytestmark = pytest.mark.gl

CAMERA = PinholeCamera.from_focal(320, 240, 240.0)
# Straight down from 4 m: the image shows x to the right of the world's -y and so on; 60 px are one metre of floor.
LOOK_DOWN = level_camera(np.array([0.0, 0.0, 4.0]), 0.0, -np.pi / 2)
FLOOR = box_model("floor", (20, 20, 0.1), "concrete", "floor", 90)
BOX = box_model("box", (0.6, 0.6, 0.6))


def floor_scene(lights: list[Light], with_box: bool = False, **options: float) -> SceneSpec:
    placed = [("floor", at(0, 0, -0.05))] + ([("box", at(0, 0, 0.3))] if with_box else [])
    return make_scene([FLOOR, BOX], placed, lights, **options)


def picture(renderer: Renderer, scene: SceneSpec, T_world_camera: np.ndarray = LOOK_DOWN) -> np.ndarray:
    renderer.load(scene)
    return renderer.render(CAMERA, T_world_camera).rgb.astype(int)


def to_code(linear: float) -> float:
    """The ACES fit by Narkowicz and the sRGB curve, in 64 bits."""
    x = linear * (2.51 * linear + 0.03) / (linear * (2.43 * linear + 0.59) + 0.14)
    return 255.0 * (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055)


def pixel_of(x: float, y: float, z: float = 0.0) -> tuple[int, int]:
    """Return row and column of a world point in the picture from above."""
    p = np.linalg.inv(LOOK_DOWN) @ np.array([x, y, z, 1.0])
    u, v = CAMERA.project(p[:3])
    return round(float(v)), round(float(u))


def test_a_diffuse_floor_has_the_brightness_of_lamberts_law(renderer: Renderer) -> None:
    """A black, rough floor reflects only its 4 % of gloss, a grey one albedo / pi of the illuminance on top of it."""
    lamp = spot((0.0, 0.0, 3.0), 1800.0)
    for x, y in ((0.0, 0.0), (0.9, 0.5), (-1.0, 0.2)):
        values = []
        for albedo in (0.0, 0.31):
            paint = {**MATERIALS, "concrete": Material("concrete", (albedo,) * 3, roughness=1.0)}
            scene = replace(floor_scene([lamp], ambient=0.0, exposure=0.01), materials=paint)
            values.append(picture(renderer, scene)[pixel_of(x, y)][0])
        squared = 9.0 + x * x + y * y
        illuminance = 1800.0 * (3.0 / np.sqrt(squared)) / squared
        matt = 0.31 / np.pi * illuminance * 0.01
        grid = np.linspace(0, 2, 20001)
        gloss = grid[np.argmin([abs(to_code(value) - values[0]) for value in grid])]
        assert 0.0 < gloss < 0.2 * matt
        assert values[1] == pytest.approx(to_code(matt + gloss), abs=1.5)


def test_ambient_light_alone_is_even_and_obeys_exposure(renderer: Renderer) -> None:
    dim, bright = (picture(renderer, floor_scene([], ambient=60.0, exposure=e)) for e in (0.01, 0.02))
    same = picture(renderer, floor_scene([], ambient=120.0, exposure=0.01))
    assert np.ptp(dim.reshape(-1, 3), axis=0).max() <= 2
    assert (bright > dim + 5).all()
    assert np.abs(bright - same).max() <= 1


def test_a_lamp_less_is_darker_everywhere_in_its_cone(renderer: Renderer) -> None:
    left, right = spot((0.0, 1.0, 3.0)), spot((0.0, -1.0, 3.0))
    both, one = (picture(renderer, floor_scene(lights)) for lights in ([left, right], [left]))
    assert (both >= one).all()
    assert (both - one)[pixel_of(0.0, -1.0)].min() > 10


def test_a_spot_lights_its_cone_and_nothing_else(renderer: Renderer) -> None:
    lamp = replace(spot((0.0, 0.0, 2.0)), cone_inner=0.2, cone_outer=0.4)
    lit, dark = picture(renderer, floor_scene([lamp])), picture(renderer, floor_scene([]))
    reach = 2.0 * np.tan(0.4)
    assert np.array_equal(lit[pixel_of(reach + 0.05, 0)], dark[pixel_of(reach + 0.05, 0)])
    assert (lit[pixel_of(reach - 0.2, 0)] > dark[pixel_of(reach - 0.2, 0)]).all()
    point = replace(lamp, kind="point")
    assert (picture(renderer, floor_scene([point]))[pixel_of(1.9, 0)] > dark[pixel_of(1.9, 0)] + 20).all()


def test_the_shadow_falls_where_the_rays_are_blocked(renderer: Renderer) -> None:
    """A lamp at x = -2, z = 2.6 over a box 0.6 m high: its far top edge at x = 0.3 throws the shadow to x = 0.99."""
    lamp = spot((-2.0, 0.0, 2.6))
    shaded = picture(renderer, floor_scene([lamp], with_box=True))
    unshaded = picture(renderer, floor_scene([replace(lamp, casts_shadow=False)], with_box=True))
    dark = picture(renderer, floor_scene([], with_box=True))
    end = -2.0 + 2.3 * 2.6 / 2.0
    for x in np.arange(0.5, end - 0.06, 0.05):  # from beside the box's foot, hidden from above until 0.35, to the end
        assert np.abs(shaded[pixel_of(x, 0)] - dark[pixel_of(x, 0)]).max() <= 2
        assert (shaded[pixel_of(x, 0)] < unshaded[pixel_of(x, 0)] - 30).all()
    for x, y in ((end + 0.08, 0.0), (0.6, 0.75), (0.6, -0.75), (-0.6, 0.0)):
        assert np.abs(shaded[pixel_of(x, y)] - unshaded[pixel_of(x, y)]).max() <= 1


def test_shadows_start_at_the_foot_of_what_casts_them(renderer: Renderer) -> None:
    """Seen along the floor from behind the box: no bright gap between box and shadow."""
    lamp = spot((-2.0, 0.0, 2.6))
    T = level_camera(np.array([2.5, 0.0, 0.8]), np.pi, -0.25)
    foot = CAMERA.project((np.linalg.inv(T) @ np.array([0.3, 0.0, 0.0, 1.0]))[:3])
    column = picture(renderer, floor_scene([lamp], with_box=True), T)[:, round(float(foot[0]))]
    dark = picture(renderer, floor_scene([], with_box=True), T)[:, round(float(foot[0]))]
    below_edge = slice(round(float(foot[1])) + 2, round(float(foot[1])) + 12)
    assert np.abs(column[below_edge] - dark[below_edge]).max() <= 3


@pytest.mark.parametrize("yaw", [0.0, 0.5])
def test_lit_surfaces_do_not_shade_themselves(renderer: Renderer, yaw: float) -> None:
    """A lone box without anything near it: with and without its shadow map its lit faces are the same."""
    lamp = spot((-2.5, -1.0, 3.0))
    T = level_camera(np.array([-2.5, -1.2, 1.2]), 0.45, -0.25)
    pictures = []
    for casts in (True, False):
        scene = make_scene([BOX], [("box", at(0, 0, 0.7, yaw))], [replace(lamp, casts_shadow=casts)])
        pictures.append(picture(renderer, scene, T))
    shown = renderer.render(CAMERA, T).instance_ids == 1
    assert np.count_nonzero(shown) > 3000
    inner = cv2.erode(shown.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    assert np.abs(pictures[0] - pictures[1])[inner].max() <= 1


@pytest.mark.parametrize("incidence_deg", [35, 50, 70])
def test_the_back_of_a_thin_sheet_hardly_shades_its_front(renderer: Renderer, incidence_deg: float) -> None:
    """Racks are of sheet metal: 4 mm upright sheets against a lamp five metres away, next to a wide shadow map."""
    angle = np.deg2rad(incidence_deg)
    lamp = replace(spot((0.0, -5.0 * np.cos(angle), 1 + 5.0 * np.sin(angle))), cone_inner=1.2, cone_outer=1.3)
    models = [box_model("sheet", (1.0, 0.004, 1.0)), box_model("wall", (20, 0.2, 4))]
    placed = [("sheet", at(0, 0, 1)), ("wall", at(0, 2.5, 0))]
    T = level_camera(np.array([0.0, -2.5, 1.0]), np.pi / 2)
    shaded, unshaded = (
        picture(renderer, make_scene(models, placed, [replace(lamp, casts_shadow=casts)]), T) for casts in (True, False)
    )
    shown = cv2.erode((renderer.render(CAMERA, T).instance_ids == 1).astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    assert unshaded[shown].min() > 40
    assert np.abs(shaded - unshaded)[shown].mean() < 3.0


def test_emission_needs_no_lamp(renderer: Renderer) -> None:
    paint = {**MATERIALS, "kraft": Material("kraft", (1.0, 1.0, 1.0), emission=0.5)}
    scene = replace(floor_scene([], with_box=True, ambient=0.0), materials=paint)
    image = picture(renderer, scene)
    assert image[pixel_of(0, 0, 0.6)] == pytest.approx([to_code(0.5)] * 3, abs=1.5)
    assert (image[pixel_of(1.5, 0)] == 0).all()


@pytest.fixture
def own_textures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(materials, "texture_path", lambda name: tmp_path / f"{name}.png")
    return tmp_path


def textured(renderer: Renderer, size: tuple[float, float, float]) -> np.ndarray:
    paint = {**MATERIALS, "kraft": replace(MATERIALS["kraft"], texture="test", texture_size=0.5)}
    scene = make_scene([box_model("box", size)], [("box", at(0, 0, -size[2] / 2))], materials=paint, ambient=300.0)
    return picture(renderer, scene)


def test_a_texture_of_128_changes_nothing_and_brighter_is_brighter(renderer: Renderer, own_textures: Path) -> None:
    plain = picture(renderer, make_scene([BOX], [("box", at(0, 0, -0.3))], ambient=300.0))
    changes = []
    for level in (64, 128, 200):
        cv2.imwrite(str(own_textures / "test.png"), np.full((64, 64), level, np.uint8))
        changes.append((textured(renderer, (0.6, 0.6, 0.6)) - plain)[pixel_of(0, 0)])
    darker, same, brighter = changes
    assert (darker < -10).all()
    assert np.abs(same).max() <= 1
    assert (brighter > 10).all()


@pytest.mark.parametrize(("size", "along_rows"), [((2.0, 1.0, 0.1), False), ((1.0, 2.0, 0.1), True)])
def test_the_grain_runs_along_the_longest_edge(
    renderer: Renderer, own_textures: Path, size: tuple[float, float, float], along_rows: bool
) -> None:
    """Stripes along u: the picture is even along the box's longest edge; one tile across is half a metre."""
    stripes = np.zeros((512, 512), np.uint8)
    stripes[:256] = 200
    cv2.imwrite(str(own_textures / "test.png"), stripes)
    patch = textured(renderer, size)[100:140, 140:180, 0]
    even, striped = patch.std(axis=1 if along_rows else 0).max(), patch.std(axis=0 if along_rows else 1).max()
    assert even < 2.0
    assert striped > 20.0


def test_a_missing_texture_is_named_with_those_that_exist(renderer: Renderer, own_textures: Path) -> None:
    cv2.imwrite(str(own_textures / "oak.png"), np.zeros((8, 8), np.uint8))
    with pytest.raises(RenderError, match=r"texture 'test': .*test\.png does not exist; textures there: oak"):
        textured(renderer, (1, 1, 1))
    (own_textures / "test.png").write_text("no image")
    with pytest.raises(RenderError, match="is not a readable image"):
        textured(renderer, (1, 1, 1))
