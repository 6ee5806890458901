"""Film changes the colour and nothing that a label is made of."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from warehouse_sim.catalog.materials import materials
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.render.textures import veil
from warehouse_sim.schema import Material, ObjectModel, RenderBuffers, SceneSpec

pytestmark = pytest.mark.gl

CAMERA = PinholeCamera.from_focal(320, 240, 240.0)
VIEW = level_camera(np.array([-3.0, 0.0, 1.2]), 0.0, -0.25)
LIGHT = spot((-2.0, 1.0, 3.5), 2500.0)
CENTRE = (120, 160)
PLACED = [("floor", at(0, 0, -0.05)), ("carton", at(0, 0, 0.3)), ("wrap", at(0, 0, 0.3)), ("post", at(-0.8, 0.1, 0.3))]


def film_scene(opacity: float | None, base: float = 0.8, texture: str | None = None) -> SceneSpec:
    """A carton on the floor, wrapped unless ``opacity`` is None, and a post before a part of it."""
    film = Material("film", (base,) * 3, roughness=0.3, texture=texture, opacity=1.0 if opacity is None else opacity)
    models: list[ObjectModel] = [
        box_model("floor", (20, 20, 0.1), "concrete", "floor", 90),
        box_model("carton", (0.6, 0.6, 0.6)),
        box_model("wrap", (0.62, 0.62, 0.62), "film", "wrap", 91),
        box_model("post", (0.12, 0.12, 0.6), "steel", "rack", 92),
    ]
    placed = [item for item in PLACED if opacity is not None or item[0] != "wrap"]
    scene = make_scene(models, placed, [LIGHT], materials={**MATERIALS, "film": film}, ambient=60.0)
    numbers = {name: number for number, (name, _) in enumerate(PLACED, start=1)}
    return replace(scene, instances=tuple(replace(item, instance_id=numbers[item.model]) for item in scene.instances))


def sampled(renderer: Renderer, scene: SceneSpec) -> RenderBuffers:
    renderer.load(scene)
    return renderer.render(CAMERA, VIEW, normals=True)


@pytest.mark.parametrize("base", [0.0, 0.95])
def test_film_dims_or_lightens_by_its_colour_and_opacity(renderer: Renderer, base: float) -> None:
    levels = [sampled(renderer, film_scene(opacity, base)).rgb[CENTRE].mean() for opacity in (None, 0.15, 0.4, 0.8)]
    steps = np.diff(levels)
    assert (steps > 4.0).all() if base > 0.5 else (steps < -4.0).all()


def test_what_stands_before_the_film_is_untouched(renderer: Renderer) -> None:
    bare, wrapped = (sampled(renderer, film_scene(opacity)) for opacity in (None, 0.8))
    assert wrapped.normals is not None
    # Colours are smoothed across the post's outline and between its faces.
    edges = cv2.Canny(wrapped.instance_mask.astype(np.uint8) * 60, 1, 2) > 0
    edges |= np.abs(np.diff(wrapped.normals, axis=0, append=0)).max(axis=2) > 0.1
    inner = (wrapped.instance_mask == 4) & (cv2.dilate(edges.astype(np.uint8), np.ones((7, 7), np.uint8)) == 0)
    assert np.count_nonzero(inner) > 150
    assert np.array_equal(wrapped.rgb[inner], bare.rgb[inner])


def test_film_casts_no_shadow_and_has_no_amodal_mask(renderer: Renderer) -> None:
    bare, wrapped = (sampled(renderer, film_scene(opacity)) for opacity in (None, 0.4))
    floor = (wrapped.instance_mask == 1) & (np.abs(wrapped.rgb.astype(int) - bare.rgb).max(axis=2) > 0)
    # Only where the film's own outline stands out over the floor.
    assert np.count_nonzero(floor) < 0.03 * np.count_nonzero(wrapped.instance_mask == 1)
    scene = film_scene(0.4)
    renderer.load(scene)
    carton, wrap = renderer.amodal_masks(CAMERA, VIEW, [scene.instances[1], scene.instances[2]])
    assert wrap.mask.size == 0
    renderer.load(film_scene(None))
    alone = renderer.amodal_masks(CAMERA, VIEW, [scene.instances[1]])[0]
    assert carton.offset == alone.offset
    assert np.array_equal(carton.mask, alone.mask)


def test_the_farther_film_is_drawn_first(renderer: Renderer) -> None:
    """A black sheet before a white one is darker than the white one before the black, however they are listed."""
    models = [box_model("floor", (20, 20, 0.1), "concrete", "floor", 90)]
    models += [box_model(name, (0.01, 1.0, 1.0), name, "wrap", 91) for name in ("black", "white")]
    sheets = {name: Material(name, (base,) * 3, 1.0, opacity=0.6) for name, base in (("black", 0.0), ("white", 0.9))}
    levels = {}
    for near, far in (("black", "white"), ("white", "black")):
        for order in ((near, far), (far, near)):
            x = {near: -0.5, far: 0.5}
            placed = [("floor", at(0, 0, -0.05)), *((name, at(x[name], 0, 0.6)) for name in order)]
            scene = make_scene(models, placed, [LIGHT], materials={**MATERIALS, **sheets}, ambient=200.0)
            levels[near, order] = sampled(renderer, scene).rgb[CENTRE].mean()
    assert levels["black", ("black", "white")] == levels["black", ("white", "black")]
    assert levels["white", ("black", "white")] == levels["white", ("white", "black")]
    assert levels["black", ("black", "white")] < levels["white", ("white", "black")] - 20


RED = Material("red", (0.42, 0.02, 0.018), 0.8)
CLOSE = PinholeCamera.from_focal(320, 240, 600.0)


def red_carton(renderer: Renderer, wrapped: bool) -> RenderBuffers:
    """A red carton, bare or in the densest film."""
    models = [
        box_model("floor", (20, 20, 0.1), "concrete", "floor", 90),
        box_model("carton", (0.6, 0.6, 0.6), "red"),
        box_model("wrap", (0.62, 0.62, 0.62), "film", "wrap", 91),
    ]
    found = {**MATERIALS, "red": RED, "film": materials()["stretch_film_dense"]}
    placed = [("floor", at(0, 0, -0.05)), ("carton", at(0, 0, 0.3)), ("wrap", at(0, 0, 0.3))]
    lights = [LIGHT, spot((-2.5, -1.0, 3.5), 2500.0)]
    renderer.load(make_scene(models, placed if wrapped else placed[:2], lights, materials=found, ambient=60.0))
    return renderer.render(CLOSE, VIEW)


def test_goods_keep_their_colour_behind_film(renderer: Renderer) -> None:
    """Clear film mirrors rather than scatters; a flat veil of its opacity would leave half of the saturation."""
    bare, wrapped = (red_carton(renderer, wrapped) for wrapped in (False, True))
    saturation = [
        cv2.cvtColor(item.rgb, cv2.COLOR_RGB2HSV)[110:170, 120:200, 1].astype(float) for item in (bare, wrapped)
    ]
    assert np.median(saturation[1]) > 0.6 * np.median(saturation[0])


def test_strands_of_film_are_level_and_far_brighter_than_what_lies_between(renderer: Renderer) -> None:
    green = red_carton(renderer, True).rgb[70:170, 110:210, 1].astype(float)
    assert np.percentile(green, 98) > np.median(green) + 40.0
    # Brightness changes from row to row, far less along them.
    assert np.abs(np.diff(green, axis=0)).mean() > 2.0 * np.abs(np.diff(green, axis=1)).mean()


def test_dyed_film_hides_what_clear_film_does_not() -> None:
    film = materials()["stretch_film"]
    layers = [veil(replace(film, opacity=opacity)) for opacity in (0.13, 0.28, 0.46, 0.85)]
    assert np.all(np.array(layers[:3]) < 0.34 * np.array([0.13, 0.28, 0.46]))
    assert 0.7 < layers[3] < 0.85
    assert veil(replace(film, texture=None)) == film.opacity
