"""What the half-resolution pass adds to an image: dark corners, soft shadows, and nothing where nothing is."""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.render.test_shading import CAMERA, LOOK_DOWN, pixel_of
from warehouse_sim.catalog.building.shell import wall_clad
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.schema import Light, Material, SceneSpec

pytestmark = pytest.mark.gl

FLOOR = box_model("floor", (20, 20, 0.1), "concrete", "floor", 90)
BLACK = {**MATERIALS, "black": Material("black", (0.0, 0.0, 0.0), 1.0)}


def linear(codes: np.ndarray) -> np.ndarray:
    """Undo the display transform by table."""
    x = np.linspace(0.0, 4.0, 40001)
    curve = np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0)
    shown = 255.0 * np.where(curve > 0.0031308, 1.055 * curve ** (1 / 2.4) - 0.055, 12.92 * curve)
    return np.interp(codes, shown, x)


def render_rgb(renderer: Renderer, scene: SceneSpec, T_world_camera: np.ndarray = LOOK_DOWN) -> np.ndarray:
    renderer.load(scene)
    return linear(renderer.render(CAMERA, T_world_camera).rgb.astype(float))


@pytest.mark.parametrize("albedo", [0.2, 0.6])
def test_an_open_floor_has_the_brightness_of_the_sky(renderer: Renderer, albedo: float) -> None:
    """Albedo / pi of ``ambient``, and the gloss of a rough dielectric, which a black floor shows alone.

    Matt surfaces scatter as Burley 2015 says: looked straight at under an even sky, the mean over directions of
    (1 - F/2) + 2 roughness cos^2(half the angle) F with F = (1 - cosine)^5.
    """
    cosine = (np.arange(4000) + 0.5) / 4000
    fresnel = (1.0 - cosine) ** 5
    scattered = 2.0 * np.mean(cosine * (1.0 - fresnel / 2.0 + (1.0 + cosine) * fresnel))
    values = []
    for fraction in (0.0, albedo):
        paint = {**MATERIALS, "concrete": Material("concrete", (fraction,) * 3, 1.0)}
        scene = make_scene([FLOOR], [("floor", at(0, 0, -0.05))], materials=paint, ambient=250.0, exposure=0.01)
        values.append(render_rgb(renderer, scene)[pixel_of(0.5, 0.3)][0])
    assert values[1] - values[0] == pytest.approx(scattered * albedo / np.pi * 250.0 * 0.01, rel=0.02)


def test_walls_see_half_of_the_sky_and_half_of_the_ground(renderer: Renderer) -> None:
    """A thin white sheet high up, seen from the front: (1 + 0.3) / 2 of what an upward one gets."""
    paint = {"white": Material("white", (0.6,) * 3, 1.0)}
    sheet = box_model("sheet", (0.05, 3.0, 3.0), "white")
    scene = make_scene([sheet], [("sheet", at(3.0, 0, 20))], materials=paint, ambient=200.0, exposure=0.01)
    value = render_rgb(renderer, scene, level_camera(np.array([0.0, 0.0, 20.0]), 0.0))[120, 160, 0]
    assert value == pytest.approx((0.6 / np.pi + 0.02) * 0.65 * 200.0 * 0.01, rel=0.1)


def test_the_foot_of_a_wall_is_darker_and_the_floor_far_from_it_is_not(renderer: Renderer) -> None:
    """Black things return no light, so that what is missing is what the wall hides; without it the floor is even."""
    models = [FLOOR, box_model("wall", (0.2, 6.0, 2.0), "black")]
    placed = [("floor", at(0, 0, -0.05)), ("wall", at(1.1, 0, 1.0))]
    bare, walled = (
        render_rgb(renderer, make_scene(models, placed[:count], materials=BLACK, ambient=300.0)) for count in (1, 2)
    )
    near, middle, far = ((walled / bare)[pixel_of(x, 0.0)].mean() for x in (0.95, 0.6, -1.4))
    assert 0.3 < near < 0.75
    assert near < middle - 0.1
    assert middle < far
    assert far > 0.85
    assert np.ptp(bare[20:-20, 20:-20], axis=(0, 1)).max() < 0.03 * bare.mean()


def penumbra(renderer: Renderer, height: float, radius: float) -> float:
    """Width (m) over which a plate's shadow on the floor goes from a fifth to four fifths."""
    light = replace(spot((-1.0, 0.0, 3.5), 3000.0), radius=radius, cone_inner=1.0, cone_outer=1.2)
    # Walls far off, as a hall has them: the map spreads over all that can cast a shadow.
    models = [FLOOR, box_model("plate", (4.0, 4.0, 0.02), "black"), box_model("wall", (0.2, 16.0, 2.0), "black")]
    placed = [("floor", at(0, 0, -0.05)), ("plate", at(-2.0, 0, height))]
    placed += [("wall", at(x, 0, 1.0)) for x in (-8.0, 8.0)]
    view = level_camera(np.array([1.6, 0.0, 1.2]), np.pi, -0.9)
    scene = make_scene(models, placed, [light], materials=BLACK, ambient=0.0, exposure=0.02)
    lit = replace(light, casts_shadow=False)
    shaded, unshaded = (render_rgb(renderer, item, view) for item in (scene, replace(scene, lights=(lit,))))
    ratio = shaded / np.maximum(unshaded, 1e-6)
    points = np.linalg.inv(view) @ np.stack([xs := np.linspace(0.0, 1.5, 600), 0 * xs, 0 * xs, 1 + 0 * xs])
    columns, rows = CAMERA.project(points[:3].T).T
    inside = (rows > 2) & (rows < CAMERA.height - 3)
    profile = ratio[np.rint(rows[inside]).astype(int), np.rint(columns[inside]).astype(int), 0]
    edge = xs[inside]
    return float(edge[np.argmax(profile > 0.8)] - edge[np.argmax(profile > 0.2)])


def test_a_penumbra_widens_with_the_height_of_what_casts_it_and_with_the_light(renderer: Renderer) -> None:
    low, high = penumbra(renderer, 0.3, 0.15), penumbra(renderer, 1.0, 0.15)
    assert low < high - 0.02
    assert penumbra(renderer, 1.0, 0.02) < 0.75 * high


def test_each_of_eight_lights_has_its_shadow(renderer: Renderer) -> None:
    """One light after the other is the strongest by far; under a plate its light is gone."""
    models = [FLOOR, box_model("plate", (1.0, 1.0, 0.05), "black")]
    placed = [("floor", at(0, 0, -0.05)), ("plate", at(0, 0, 0.5))]
    places = [(0.3 * np.cos(a), 0.3 * np.sin(a), 3.0) for a in np.arange(8) * np.pi / 4]
    view = level_camera(np.array([-1.6, 0.0, 0.35]), 0.0, -0.15)

    def lights(strong: int, shadow: bool) -> list[Light]:
        return [
            replace(spot(place, 500.0 if k == strong else 0.1), casts_shadow=shadow) for k, place in enumerate(places)
        ]

    under = CAMERA.project((np.linalg.inv(view) @ np.array([0.0, 0.0, 0.0, 1.0]))[:3])
    pixel = round(float(under[1])), round(float(under[0]))

    def under_the_plate(strong: int, shadow: bool) -> float:
        scene = make_scene(models, placed, lights(strong, shadow), materials=BLACK, ambient=0.0)
        return render_rgb(renderer, scene, view)[pixel][0]

    unshaded = under_the_plate(0, False)  # all eight stand equally far from the point
    for strong in range(8):
        assert under_the_plate(strong, True) < 0.2 * unshaded


def test_in_a_hall_the_shade_under_a_low_shelf_is_dark_to_its_edge(renderer: Renderer) -> None:
    """Six lamps under the roof of a hall of 40 m, walls as high as they: a map that shows all has coarse texels."""
    lights = [
        replace(spot((x, 0.0, 10.0), 2000.0), radius=0.02, cone_inner=0.7, cone_outer=1.48)
        for x in (-0.5, -0.3, -0.1, 0.1, 0.3, 0.5)
    ]
    models = [FLOOR, box_model("shelf", (4.0, 4.0, 0.05), "black"), box_model("wall", (0.2, 30.0, 9.8), "black")]
    placed = [("floor", at(0, 0, -0.05)), ("shelf", at(-2.0, 0, 0.4))]
    placed += [("wall", at(x, 0, 4.9)) for x in (-20.0, 20.0)]
    view = level_camera(np.array([1.6, 0.0, 0.35]), np.pi, -0.22)
    scene = make_scene(models, placed, lights, materials=BLACK, ambient=0.0, exposure=0.02)
    bare = replace(scene, lights=tuple(replace(light, casts_shadow=False) for light in lights))
    shaded, unshaded = (render_rgb(renderer, item, view) for item in (scene, bare))
    u, v = CAMERA.project((np.linalg.inv(view) @ np.array([-0.12, 0.0, 0.0, 1.0]))[:3])
    pixel = round(float(v)), round(float(u))
    assert unshaded[pixel][0] > 0.1
    assert shaded[pixel][0] < 0.1 * unshaded[pixel][0]


TO_WALL = np.array([0.8, -0.2, -0.566])
RIBBED = {**MATERIALS, "cladding": Material("cladding", (0.5, 0.5, 0.5), 0.8)}


def ribbed_wall(renderer: Renderer, lights: Sequence[Light], pitch: float) -> np.ndarray:
    """Return the image of a clad wall eight metres ahead, its ribs 35 mm deep and 0.2 m apart."""
    models = [wall_clad(), box_model("post", (0.2, 0.2, 0.2), "concrete")]
    placed = [("wall_clad", at(8.1, 0, 4.5, np.pi / 2)), ("post", at(4, -6, 0)), ("post", at(-4, 6, 0))]
    scene = make_scene(models, placed, lights, materials=RIBBED, ambient=0.0 if lights else 300.0, exposure=0.02)
    return render_rgb(renderer, scene, level_camera(np.array([0.0, 0.0, 1.5]), 0.25, pitch))


def test_ribs_cast_no_pattern_on_their_wall(renderer: Renderer) -> None:
    """Sides of ribs that look away from the light are dark; nothing else is, as with a light that casts no shadows."""
    light = replace(spot((4.4, 5.0, 5.6), 5000.0), direction=TO_WALL, cone_inner=0.8, cone_outer=1.1, radius=0.15)
    for pitch in (0.0, 0.3):
        shaded, unshaded = (
            ribbed_wall(renderer, [replace(light, casts_shadow=casts)], pitch) for casts in (True, False)
        )
        lit = cv2.erode((unshaded[..., 0] > 0.05).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        assert np.count_nonzero(lit) > 10_000
        assert np.mean(shaded[lit] < 0.9 * unshaded[lit]) < 0.03


def test_ribs_too_fine_to_resolve_leave_no_rings_in_even_light(renderer: Renderer) -> None:
    """The wall is the same at every height: along a trough between its ribs the image hardly changes."""
    image = ribbed_wall(renderer, [], 0.2)[..., 1]
    T_camera_world = np.linalg.inv(level_camera(np.array([0.0, 0.0, 1.5]), 0.25, 0.2))
    heights = np.arange(1.5, 7.0, 0.02)
    unevenness = []
    for y in np.arange(-0.6, 4.4, 0.2):  # the middle of a trough 0.12 m wide is at each multiple of 0.2 m
        trough = np.stack([np.full_like(heights, 8.035), np.full_like(heights, y), heights, np.ones_like(heights)])
        columns, rows = np.rint(CAMERA.project((T_camera_world @ trough)[:3].T)).astype(int).T
        inside = (columns >= 0) & (columns < CAMERA.width) & (rows >= 0) & (rows < CAMERA.height)
        values = image[rows[inside], columns[inside]]
        unevenness.append(np.std(values[12:-12] / np.convolve(values, np.full(25, 1 / 25), "valid")))
    assert np.mean(unevenness) < 0.012


def test_a_dark_face_lends_its_neighbour_no_brightness(renderer: Renderer) -> None:
    """Sides of ribs that no light reaches lie between faces that a light reaches: nowhere does a pixel flash up."""
    light = replace(spot((4.4, 5.0, 5.6), 5000.0), direction=TO_WALL, cone_inner=0.8, cone_outer=1.1, radius=0.15)
    shaded, unshaded = (ribbed_wall(renderer, [replace(light, casts_shadow=casts)], 0.3) for casts in (True, False))
    assert unshaded.mean() > 0.1
    assert (shaded < 1.1 * unshaded + 0.02).all()
