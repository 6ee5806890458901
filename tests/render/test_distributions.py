"""Photometric files in the images: against the built-in formula, and turned with the luminaire."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.render.opened import open_pathtracer
from warehouse_sim.generation.light import LightMeter
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.render.irradiance import LightGatherer
from warehouse_sim.render.light_grid import lay_grid
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.lighting.photometry import relative_intensity
from warehouse_sim.schema import IntensityDistribution, Light, Material, SceneSpec

FLOOR = box_model("floor", (40, 40, 0.1), "concrete", "floor", 90)
CAMERA = PinholeCamera.from_focal(64, 48, 40.0)
DOWN = np.array([0.0, 0.0, -1.0])


def distribution(fraction: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> IntensityDistribution:
    """Return one that is ``fraction`` of angle from the axis and half plane (rad)."""
    turned, angle = np.meshgrid(np.arange(144) * np.pi / 72, np.deg2rad(np.arange(181.0)), indexing="ij")
    return IntensityDistribution("made", 1.0, fraction(angle, turned).astype(np.float32))


def as_formula(light: Light) -> IntensityDistribution:
    def fraction(angle: np.ndarray, _: np.ndarray) -> np.ndarray:
        cosine = np.cos(angle).ravel()
        return relative_intensity(light, cosine, np.zeros((len(cosine), 3))).reshape(angle.shape)

    return distribution(fraction)


def scene_of(light: Light) -> SceneSpec:
    paint = {**MATERIALS, "concrete": Material("concrete", (0.5,) * 3, roughness=1.0)}
    table = box_model("table", (1.0, 1.0, 0.6), "concrete", "rack", 91)
    placed = [("floor", at(0, 0, -0.05)), ("table", at(1.5, 0.5, 0.3))]
    return make_scene([FLOOR, table], placed, [light], materials=paint, ambient=5.0, exposure=0.002)


def image(renderer: Renderer, light: Light) -> np.ndarray:
    renderer.load(scene_of(light))
    return renderer.render(CAMERA, level_camera(np.array([0.0, 0.0, 5.5]), 0.0, -np.pi / 2)).rgb.astype(int)


LAMP = replace(spot((0.0, 0.0, 4.0), 4000.0), radius=0.1, cone_inner=0.4, cone_outer=1.4)


@pytest.mark.gl
def test_the_built_in_formula_as_a_file_gives_the_same_image(renderer: Renderer) -> None:
    plain, measured = (image(renderer, lamp) for lamp in (LAMP, replace(LAMP, distribution=as_formula(LAMP))))
    assert plain.max() > 60
    assert np.abs(plain - measured).max() <= 2
    assert np.abs(plain - measured).mean() < 0.2


def one_sided(angle: np.ndarray, turned: np.ndarray) -> np.ndarray:
    return np.where(angle < 1.5, np.cos(angle / 2) * (0.55 + 0.45 * np.cos(turned)), 0.0)


@pytest.mark.gl
def test_the_image_brightens_where_the_half_plane_0_points(renderer: Renderer) -> None:
    turn = -1.3
    along = (float(np.cos(turn)), float(np.sin(turn)), 0.0)
    light = replace(LAMP, distribution=distribution(one_sided), along=along)
    scene = scene_of(light)
    scene = replace(scene, instances=scene.instances[:1], ambient=0.0)
    points = 2.0 * np.stack([np.cos(turn + np.arange(4) * np.pi / 2), np.sin(turn + np.arange(4) * np.pi / 2)], axis=1)
    renderer.load(scene)
    values = []
    for x, y in points:
        T = level_camera(np.array([x, y, 5.0]), 0.0, -np.pi / 2)
        values.append(float(renderer.render(PinholeCamera.from_focal(8, 8, 400.0), T).rgb.mean()))
    ahead, left, behind, right = values
    assert ahead > max(left, right) + 20
    assert min(left, right) > behind + 15
    assert left == pytest.approx(right, abs=1.5)


def test_the_path_tracer_looks_up_the_same_distribution() -> None:
    turn = 0.6
    light = replace(
        LAMP,
        position=np.array([0.0, 0.0, 4.0]),
        radius=0.0,
        distribution=distribution(one_sided),
        along=(float(np.cos(turn)), float(np.sin(turn)), 0.0),
    )
    scene = replace(scene_of(light), ambient=0.0)
    scene = replace(scene, instances=scene.instances[:1])
    meter = PinholeCamera.from_focal(4, 4, 250.0)
    with open_pathtracer(samples=256, bounces=0) as renderer:

        def luminance(lamp: Light, x: float, y: float) -> float:
            renderer.load(replace(scene, lights=(lamp,)))
            return float(renderer.luminance(meter, level_camera(np.array([x, y, 10.0]), 0.0, -np.pi / 2)).mean())

        for x, y in ((2.0, 0.0), (0.0, 2.5), (-3.0, -1.0), (1.0, -2.0)):
            away = np.array([[x, y, -4.0]]) / np.linalg.norm([x, y, 4.0])
            expected = float(relative_intensity(light, away @ DOWN, away)[0])
            everywhere = replace(light, kind="point", distribution=None)
            assert luminance(light, x, y) / luminance(everywhere, x, y) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("fill", [False, True])
def test_meter_and_grid_of_irradiance_see_the_file_as_they_see_the_formula(fill: bool) -> None:
    lamp = replace(LAMP, fill=fill)
    measured = replace(lamp, distribution=as_formula(lamp))
    scene, same = scene_of(lamp), scene_of(measured)
    points = np.array([[0.0, 0.0, 0.001], [-2.0, 1.0, 0.001], [1.5, 0.5, 0.601], [6.0, -3.0, 0.001]])
    up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    plain, own = (LightMeter(item, RayCaster(item)).direct(points, up, item.lights) for item in (scene, same))
    np.testing.assert_allclose(own, plain, rtol=2e-3)
    fields = [LightGatherer(lay_grid(item)).field(item.lights, item.ambient) for item in (scene, same)]
    for before, after in zip(*(field.levels for field in fields), strict=True):
        np.testing.assert_allclose(after.irradiance, before.irradiance, atol=5e-3 * float(before.irradiance.max()))
