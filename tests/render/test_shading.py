"""Light does what physics says, as far as eight bits after a tone curve can show it."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from uuid import uuid4

import cv2
import numpy as np
import pytest

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera, rotation_z
from warehouse_sim.render import Renderer, textures
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.render.display import inverse_tone_map, to_display, tone_map
from warehouse_sim.render.raster import surfaces
from warehouse_sim.render.raster.backend import RasterRenderer
from warehouse_sim.schema import Light, Material, SceneSpec

CAMERA = PinholeCamera.from_focal(320, 240, 240.0)
# Straight down from 4 m: the image shows x to the right of the world's -y and so on; 60 px are one metre of floor.
LOOK_DOWN = level_camera(np.array([0.0, 0.0, 4.0]), 0.0, -np.pi / 2)
FLOOR = box_model("floor", (20, 20, 0.1), "concrete", "floor", 90)
BOX = box_model("box", (0.6, 0.6, 0.6))


def floor_scene(lights: list[Light], with_box: bool = False, **options: float) -> SceneSpec:
    placed = [("floor", at(0, 0, -0.05))] + ([("box", at(0, 0, 0.3))] if with_box else [])
    return make_scene([FLOOR, BOX], placed, lights, **options)


def render_rgb(renderer: Renderer, scene: SceneSpec, T_world_camera: np.ndarray = LOOK_DOWN) -> np.ndarray:
    renderer.load(scene)
    return renderer.render(CAMERA, T_world_camera).rgb.astype(int)


def to_code(linear: float) -> float:
    """The ACES fit by Narkowicz and the sRGB curve, in 64 bits."""
    x = linear * (2.51 * linear + 0.03) / (linear * (2.43 * linear + 0.59) + 0.14)
    return 255.0 * (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055)


def pixel_of(x: float, y: float, z: float = 0.0) -> tuple[int, int]:
    """Return row and column of a world point in the image from above."""
    p = np.linalg.inv(LOOK_DOWN) @ np.array([x, y, z, 1.0])
    u, v = CAMERA.project(p[:3])
    return round(float(v)), round(float(u))


@pytest.mark.gl
def test_the_ends_and_the_middle_are_where_the_fit_puts_them() -> None:
    assert tone_map(np.array([0.0, 0.18, 1.0, 1e9])) == pytest.approx([0.0, 0.2669, 0.8038, 1.0], abs=1e-4)


def test_display_values_grow_with_light_in_every_channel_and_never_wrap() -> None:
    ramp = np.linspace(-0.5, 50.0, 3000).reshape(50, 20, 3)
    shown = to_display(ramp)
    assert shown.dtype == np.uint8
    assert shown.shape == ramp.shape
    assert (np.diff(shown.reshape(-1).astype(int)) >= 0).all()
    assert shown.min() == 0
    assert shown.max() == 255


def test_the_inverse_of_the_filmic_curve() -> None:
    x = np.geomspace(1e-4, 7.0, 200)
    assert inverse_tone_map(tone_map(x)) == pytest.approx(x, rel=1e-6)
    assert inverse_tone_map(np.zeros(1)) == pytest.approx(0.0)


def test_a_diffuse_floor_has_the_brightness_of_lamberts_law(renderer: Renderer) -> None:
    """A black, rough floor reflects only its 4 % of gloss, a grey one albedo / pi of the illuminance on top of it."""
    light = spot((0.0, 0.0, 3.0), 1800.0)
    for x, y in ((0.0, 0.0), (0.9, 0.5), (-1.0, 0.2)):
        values = []
        for albedo in (0.0, 0.31):
            paint = {**MATERIALS, "concrete": Material("concrete", (albedo,) * 3, roughness=1.0)}
            scene = replace(floor_scene([light], ambient=0.0, exposure=0.01), materials=paint)
            values.append(render_rgb(renderer, scene)[pixel_of(x, y)][0])
        squared = 9.0 + x * x + y * y
        illuminance = 1800.0 * (3.0 / np.sqrt(squared)) / squared
        matt = 0.31 / np.pi * illuminance * 0.01
        grid = np.linspace(0, 2, 20001)
        gloss = grid[np.argmin([abs(to_code(value) - values[0]) for value in grid])]
        assert 0.0 < gloss < 0.2 * matt
        assert values[1] == pytest.approx(to_code(matt + gloss), abs=1.5)


@pytest.mark.gl
def test_ambient_light_alone_is_even_and_obeys_exposure(renderer: Renderer) -> None:
    dim, bright = (render_rgb(renderer, floor_scene([], ambient=60.0, exposure=e)) for e in (0.01, 0.02))
    same = render_rgb(renderer, floor_scene([], ambient=120.0, exposure=0.01))
    assert np.ptp(dim.reshape(-1, 3), axis=0).max() <= 2
    assert (bright > dim + 5).all()
    assert np.abs(bright - same).max() <= 1


@pytest.mark.gl
def test_a_spot_lights_its_cone_and_nothing_else(renderer: Renderer) -> None:
    light = replace(spot((0.0, 0.0, 2.0)), cone_inner=0.2, cone_outer=0.4)
    lit, dark = render_rgb(renderer, floor_scene([light])), render_rgb(renderer, floor_scene([]))
    reach = 2.0 * np.tan(0.4)
    # A code at most: the gloss holds a little of what points over the lit floor see beside them.
    assert np.abs(lit[pixel_of(reach + 0.05, 0)] - dark[pixel_of(reach + 0.05, 0)]).max() <= 1
    assert (lit[pixel_of(reach - 0.2, 0)] > dark[pixel_of(reach - 0.2, 0)]).all()
    point = replace(light, kind="point")
    assert (render_rgb(renderer, floor_scene([point]))[pixel_of(1.9, 0)] > dark[pixel_of(1.9, 0)] + 20).all()


@pytest.mark.gl
def test_the_shadow_falls_where_the_rays_are_blocked(renderer: Renderer) -> None:
    """A light at x = -2, z = 2.6 over a box 0.6 m high: its far top edge at x = 0.3 throws the shadow to x = 0.99."""
    light = spot((-2.0, 0.0, 2.6))
    shaded = render_rgb(renderer, floor_scene([light], with_box=True))
    unshaded = render_rgb(renderer, floor_scene([replace(light, casts_shadow=False)], with_box=True))
    dark = render_rgb(renderer, floor_scene([], with_box=True))
    end = -2.0 + 2.3 * 2.6 / 2.0
    for x in np.arange(0.5, end - 0.06, 0.05):  # from beside the box's foot, hidden from above until 0.35, to the end
        # What is left is the light that the floor around returns to the box and the box to the floor.
        assert ((shaded - dark)[pixel_of(x, 0)] < 0.1 * (unshaded - dark)[pixel_of(x, 0)] + 2).all()
        assert (shaded[pixel_of(x, 0)] < unshaded[pixel_of(x, 0)] - 30).all()
    for x, y in ((end + 0.08, 0.0), (0.6, 0.75), (0.6, -0.75), (-0.6, 0.0)):
        assert np.abs(shaded[pixel_of(x, y)] - unshaded[pixel_of(x, y)]).max() <= 1


@pytest.mark.gl
def test_shadows_start_at_the_foot_of_what_casts_them(renderer: Renderer) -> None:
    """Seen along the floor from behind the box: no bright gap between box and shadow."""
    light = spot((-2.0, 0.0, 2.6))
    T = level_camera(np.array([2.5, 0.0, 0.8]), np.pi, -0.25)
    foot = CAMERA.project((np.linalg.inv(T) @ np.array([0.3, 0.0, 0.0, 1.0]))[:3])
    column = render_rgb(renderer, floor_scene([light], with_box=True), T)[:, round(float(foot[0]))]
    dark = render_rgb(renderer, floor_scene([], with_box=True), T)[:, round(float(foot[0]))]
    below_edge = slice(round(float(foot[1])) + 2, round(float(foot[1])) + 12)
    assert np.abs(column[below_edge] - dark[below_edge]).max() <= 12  # light that floor and box return


@pytest.mark.gl
@pytest.mark.parametrize("yaw", [0.0, 0.5])
def test_lit_surfaces_do_not_shade_themselves(renderer: Renderer, yaw: float) -> None:
    """A lone box without anything near it: with and without its shadow map its lit faces are the same."""
    light = spot((-2.5, -1.0, 3.0))
    T = level_camera(np.array([-2.5, -1.2, 1.2]), 0.45, -0.25)
    images = []
    for casts in (True, False):
        scene = make_scene([BOX], [("box", at(0, 0, 0.7, yaw))], [replace(light, casts_shadow=casts)])
        images.append(render_rgb(renderer, scene, T))
    shown = renderer.render(CAMERA, T).instance_mask == 1
    assert np.count_nonzero(shown) > 3000
    inner = cv2.erode(shown.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    assert np.abs(images[0] - images[1])[inner].max() <= 1


@pytest.mark.gl
@pytest.mark.parametrize("incidence_deg", [35, 50, 70])
def test_the_back_of_a_thin_sheet_hardly_shades_its_front(renderer: Renderer, incidence_deg: float) -> None:
    """Racks are of sheet metal: 4 mm upright sheets against a light five metres away, next to a wide shadow map."""
    angle = np.deg2rad(incidence_deg)
    light = replace(spot((0.0, -5.0 * np.cos(angle), 1 + 5.0 * np.sin(angle))), cone_inner=1.2, cone_outer=1.3)
    models = [box_model("sheet", (1.0, 0.004, 1.0)), box_model("wall", (20, 0.2, 4))]
    placed = [("sheet", at(0, 0, 1)), ("wall", at(0, 2.5, 0))]
    T = level_camera(np.array([0.0, -2.5, 1.0]), np.pi / 2)
    shaded, unshaded = (
        render_rgb(renderer, make_scene(models, placed, [replace(light, casts_shadow=casts)]), T)
        for casts in (True, False)
    )
    shown = cv2.erode((renderer.render(CAMERA, T).instance_mask == 1).astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    assert unshaded[shown].min() > 40
    assert np.abs(shaded - unshaded)[shown].mean() < 3.0


@pytest.mark.gl
def test_emission_needs_no_light_and_obeys_exposure(renderer: Renderer) -> None:
    paint = {**MATERIALS, "kraft": Material("kraft", (1.0, 1.0, 1.0), emission=50.0)}
    for exposure in (0.01, 0.002):
        scene = replace(floor_scene([], with_box=True, ambient=0.0, exposure=exposure), materials=paint)
        image = render_rgb(renderer, scene)
        assert image[pixel_of(0, 0, 0.6)] == pytest.approx([to_code(50.0 * exposure)] * 3, abs=1.5)
        assert (image[pixel_of(1.5, 0)] == 0).all()


@pytest.fixture(scope="module")
def texturing() -> Iterator[Renderer]:
    """A renderer of its own that holds these textures alone: it uploads all that it has with each new one."""
    with RasterRenderer() as opened:
        yield opened


@pytest.fixture
def own_textures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of textures, all of which are small on the device, too."""
    monkeypatch.setattr(textures, "texture_folder", lambda name: tmp_path / name)
    monkeypatch.setattr(surfaces, "TEXTURE_EDGE_PX", 128)
    return tmp_path


def own_texture(folder: Path, kind: str, pixels: np.ndarray) -> str:
    """Store one image of a set; return the set's name, a new one each time, because a renderer keeps what it read."""
    name = f"test{uuid4().hex}"
    (folder / name).mkdir()
    cv2.imwrite(str(folder / name / "albedo.png"), np.full((64, 64), 128, np.uint8))
    cv2.imwrite(str(folder / name / f"{kind}.png"), pixels)
    return name


def textured(texturing: Renderer, size: tuple[float, float, float], texture: str) -> np.ndarray:
    paint = {**MATERIALS, "kraft": replace(MATERIALS["kraft"], texture=texture, texture_size=0.5)}
    scene = make_scene([box_model("box", size)], [("box", at(0, 0, -size[2] / 2))], materials=paint, ambient=300.0)
    return render_rgb(texturing, scene)


@pytest.mark.gl
def test_a_texture_of_128_changes_nothing_and_brighter_is_brighter(texturing: Renderer, own_textures: Path) -> None:
    plain = render_rgb(texturing, make_scene([BOX], [("box", at(0, 0, -0.3))], ambient=300.0))
    changes = []
    for level in (64, 128, 200):
        name = own_texture(own_textures, "albedo", np.full((64, 64), level, np.uint8))
        changes.append((textured(texturing, (0.6, 0.6, 0.6), name) - plain)[pixel_of(0, 0)])
    darker, same, brighter = changes
    assert (darker < -10).all()
    assert np.abs(same).max() <= 1
    assert (brighter > 10).all()


@pytest.mark.gl
@pytest.mark.parametrize(("size", "along_rows"), [((2.0, 1.0, 0.1), False), ((1.0, 2.0, 0.1), True)])
def test_the_grain_runs_along_the_longest_edge(
    texturing: Renderer, own_textures: Path, size: tuple[float, float, float], along_rows: bool
) -> None:
    """Stripes along u: the image is even along the box's longest edge; one tile across is half a metre."""
    stripes = np.zeros((512, 512), np.uint8)
    stripes[:256] = 200
    patch = textured(texturing, size, own_texture(own_textures, "albedo", stripes))[100:140, 140:180, 0]
    even, striped = patch.std(axis=1 if along_rows else 0).max(), patch.std(axis=0 if along_rows else 1).max()
    assert even < 2.0
    assert striped > 20.0


def tilted(u: float, up: float) -> np.ndarray:
    """Return the BGR image of a normal that leans along u and up the image."""
    normal = np.array([u, up, np.sqrt(1.0 - u * u - up * up)])
    return np.broadcast_to(np.round(128 + 127 * normal[::-1]), (64, 64, 3)).astype(np.uint8)


@pytest.mark.gl
@pytest.mark.parametrize(("size", "turn"), [((0.6, 0.4, 0.4), 0.0), ((0.4, 0.6, 0.4), 0.7), ((0.6, 0.4, 0.4), 2.5)])
def test_a_normal_map_leans_the_light_and_nothing_else(
    texturing: Renderer, own_textures: Path, size: tuple[float, float, float], turn: float
) -> None:
    """A box seen from above under a light to its side: normals that lean towards the light are brighter, and back."""
    light = spot((1.2, 0.0, 1.2), 600.0)
    # u runs along the longest edge; seen from above v runs to its left.
    along = rotation_z(turn)[:, 0 if size[0] > size[1] else 1]
    across = np.cross([0.0, 0.0, 1.0], along)
    leans = {"flat": (0.0, 0.0)}
    for sign in (1.0, -1.0):
        leans[f"{sign}"] = (sign * 0.3 * along[0], -sign * 0.3 * across[0])  # the file's y points against v
    images = {}
    for name, (u, up) in leans.items():
        texture = own_texture(own_textures, "normal", tilted(u, up))
        paint = {**MATERIALS, "kraft": replace(MATERIALS["kraft"], texture=texture, texture_size=0.5)}
        scene = make_scene([box_model("box", size)], [("box", at(0, 0, -0.2, turn))], [light], materials=paint)
        texturing.load(scene)
        images[name] = texturing.render(CAMERA, LOOK_DOWN, normals=True)
    towards, flat, away = (int(images[name].rgb[pixel_of(0, 0)][0]) for name in ("1.0", "flat", "-1.0"))
    assert away + 8 < flat < towards - 8
    for other in images.values():
        for channel in ("depth", "instance_mask", "normals"):
            assert np.array_equal(getattr(other, channel), getattr(images["flat"], channel))


@pytest.mark.gl
def test_roughness_spreads_the_highlight(texturing: Renderer, own_textures: Path) -> None:
    paint = {**MATERIALS, "kraft": Material("kraft", (0.1, 0.1, 0.1), roughness=0.3, texture_size=0.5)}
    peaks = []
    for level in (64, 128, 255):
        texture = own_texture(own_textures, "roughness", np.full((64, 64), level, np.uint8))
        painted = {**paint, "kraft": replace(paint["kraft"], texture=texture)}
        light = spot((0.0, 0.0, 3.0), 300.0)  # just below the camera: its highlight is in the middle
        scene = make_scene([BOX], [("box", at(0, 0, -0.3))], [light], materials=painted, ambient=0.0, exposure=0.01)
        peaks.append(render_rgb(texturing, scene)[pixel_of(0, 0)][0])
    sharp, same, dull = peaks
    assert dull < same - 10 < sharp - 20


@pytest.mark.gl
def test_a_missing_texture_is_named_with_those_that_exist(texturing: Renderer, own_textures: Path) -> None:
    (own_textures / "oak").mkdir()
    with pytest.raises(RenderError, match=r"texture 'test': .*test/albedo\.png does not exist; textures there: oak"):
        textured(texturing, (1, 1, 1), "test")
    name = own_texture(own_textures, "normal", tilted(0.0, 0.0))
    (own_textures / name / "normal.png").write_text("no image")
    with pytest.raises(RenderError, match="is not a readable image"):
        textured(texturing, (1, 1, 1), name)


# Bands of vests in colour images: bright in work lights beside the lens, grey in all other light.


BOARD = box_model("board", (2.0, 0.02, 2.0), "concrete", "rack", 90)
RETROREFLECTORS_CAMERA = PinholeCamera.from_focal(32, 32, 300.0)


def brightness(renderer: Renderer, remission: float, light: Light) -> np.ndarray:
    """Return the image of a grey board 8 m before the camera."""
    paint = {**MATERIALS, "concrete": Material("concrete", (0.62,) * 3, roughness=0.9, remission=remission)}
    scene = make_scene([BOARD], [("board", at(0, 8.0, 1.0))], [light], materials=paint, ambient=0.0, exposure=0.01)
    renderer.load(scene)
    return renderer.render(RETROREFLECTORS_CAMERA, level_camera(np.array([0.0, 0.0, 1.0]), np.pi / 2)).rgb.astype(int)


def lamp(x: float, y: float = 0.0) -> Light:
    towards = np.array([-x, 8.0 - y, 0.0])
    return replace(spot((x, y, 1.0), 500.0), direction=towards / np.linalg.norm(towards), radius=0.05)


@pytest.mark.gl
def test_a_work_light_beside_the_lens_makes_a_band_brighter_than_white(renderer: Renderer) -> None:
    band, paint = (brightness(renderer, remission, lamp(0.5)).mean() for remission in (2.0, 0.9))
    assert band > 1.5 * paint
    assert brightness(renderer, 2.0, lamp(0.1)).mean() > band


@pytest.mark.gl
def test_any_other_light_leaves_every_byte_as_it_was(renderer: Renderer) -> None:
    for light in (lamp(5.0), lamp(0.0, 4.5)):
        band = brightness(renderer, 2.0, light)
        assert (band == brightness(renderer, 0.9, light)).all()
        assert band.max() > 10
