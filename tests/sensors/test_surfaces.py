"""Materials behind pixels, and light that comes back over smooth surfaces."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import CAMERA, capture_of, plane, with_constants
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import Material
from warehouse_sim.schema.things import RETROREFLECTIVE
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.model import DepthModel
from warehouse_sim.sensors.surfaces import Reflected, returned_by_retroreflectors, returned_light, see_surfaces
from warehouse_sim.sensors.view import Capture


def test_each_pixel_gets_the_material_that_its_ray_meets() -> None:
    models = [box_model("wall", (8, 0.2, 1), "concrete"), box_model("post", (0.2, 0.2, 2), "steel")]
    scene = make_scene(models, [("wall", at(0, 4, 0.5)), ("post", at(0, 2, 1.0))])
    surfaces = see_surfaces(scene, RayCaster(scene), CAMERA, level_camera(np.array([0.0, 0.0, 1.0]), np.pi / 2))
    for name, pixel in (("steel", (120, 160)), ("concrete", (200, 20))):
        assert surfaces.remission[pixel] == pytest.approx(MATERIALS[name].remission)
        assert surfaces.roughness[pixel] == pytest.approx(MATERIALS[name].roughness)
    assert surfaces.remission[20, 20] == 0.0
    # The post's face is 20 cm wide, 1.9 m away.
    assert (surfaces.roughness[120] == np.float32(0.4)).sum() == pytest.approx(0.2 / 1.9 * 585.5, abs=2.0)


def test_white_plaster_sends_back_its_cosine_and_metal_its_mirror_image() -> None:
    cosine = np.linspace(0.05, 1.0, 320, dtype=np.float32)[None].repeat(240, axis=0)
    plaster, chrome = capture_of().surfaces, capture_of(remission=1.2, roughness=0.2, metallic=1.0).surfaces
    assert plaster is not None
    assert chrome is not None
    diffuse, glossy = returned_light(plaster, cosine)
    np.testing.assert_allclose(diffuse, cosine)
    assert glossy.max() <= 0.01 + 1e-6
    diffuse, glossy = returned_light(chrome, cosine)
    assert (diffuse == 0).all()
    assert glossy[0, -1] == pytest.approx(0.25 / 0.2**4, rel=1e-3)  # 1 / (4 alpha^2) of a mirror, alpha = roughness^2
    assert glossy[0, 220] < 0.02


HEIGHT, WALL = 0.2, 2.0
SMOOTH_AND_MATT = {
    "mirror": Material("mirror", (0.2,) * 3, roughness=0.05, remission=0.3),
    "matt": Material("matt", (0.2,) * 3, roughness=0.9, remission=0.3),
}


def reflected(floor: str) -> Reflected:
    """A camera 20 cm above a floor, 2 m before a wall."""
    models = [box_model("floor", (20, 20, 0.1), floor), box_model("wall", (8, 0.2, 4), "matt")]
    scene = make_scene(
        models, [("floor", at(0, 0, -0.05)), ("wall", at(0, WALL + 0.1, 2.0))], materials=SMOOTH_AND_MATT
    )
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


# Retroreflecting bands before cameras that light what they see.


BAND = slice(100, 130)
"""Columns of the band; it is as wide as one of 50 mm at 1 m."""
BESIDE = np.r_[0:60, 170:320]
"""Columns far enough from the band that nothing of it reaches them."""


def banded(roughness: float = 0.8) -> Capture:
    capture = capture_of(remission=0.6, roughness=roughness)
    assert capture.surfaces is not None
    remission = capture.surfaces.remission.copy()
    remission[:, BAND] = RETROREFLECTIVE
    return replace(capture, surfaces=replace(capture.surfaces, remission=remission))


def read(model: DepthModel, capture: Capture, z: float = 1.5) -> np.ndarray:
    return model.read(plane(z), capture, np.random.default_rng(3))


def test_light_comes_back_as_the_standard_asks_and_less_beside_the_lamp() -> None:
    """330 cd/(lx m^2) at 12 minutes of arc (EN ISO 20471), over the 1 / pi of white plaster."""
    remission, one = np.full((1, 1), 2.0, np.float32), np.ones((1, 1), np.float32)
    z = 5.0
    at = returned_by_retroreflectors(remission, one, z * one, z * np.tan(np.deg2rad(0.2)))
    assert at is not None
    assert float(at[0, 0]) == pytest.approx(330 * np.pi, rel=1e-4)
    falling = [returned_by_retroreflectors(remission, one, z * one, offset) for offset in (0.0, 0.03, 0.1, 0.5)]
    assert all(np.diff([float(item[0, 0]) for item in falling if item is not None]) < 0)
    assert returned_by_retroreflectors(0.95 * one, one, one, 0.01) is None


@pytest.mark.parametrize("name", ["flexx2", "azure_kinect", "kinect_v1", "d435", "d455"])
def test_a_band_is_a_hole_and_what_lies_beside_it_is_read_as_before(name: str) -> None:
    model = PRESETS[name]
    plain, own = read(model, capture_of(remission=0.6, roughness=0.8)), read(model, banded())
    assert (plain[:, 105:125] > 0).mean() > 0.9
    assert (own[:, 105:125] > 0).mean() < 0.05
    # One step of disparity, where rounding falls the other way.
    np.testing.assert_allclose(own[:, BESIDE], plain[:, BESIDE], atol=5e-3)
    assert (np.abs(own - plain)[:, BESIDE] < 1e-3).mean() > 0.99


def test_a_flooded_pixel_of_a_time_of_flight_camera_reaches_beyond_the_band() -> None:
    own = read(PRESETS["flexx2"], banded())
    rim = (own[:, BAND.stop : BAND.stop + 1] == 0).mean()
    assert rim > 0.9
    assert (own[:, BAND.stop + 12 :] > 0).mean() > 0.99


def test_a_band_that_is_too_far_to_flood_a_pixel_is_read() -> None:
    model = with_constants(replace(PRESETS["flexx2"], max_range=7.0), max_signal=1e5)
    assert (read(model, banded())[:, 105:125] > 0).all()


def test_stray_light_of_a_near_band_draws_the_rest_of_the_image_nearer() -> None:
    """A band at half the distance: what its light adds to every pixel has a smaller phase."""
    model = replace(PRESETS["tof_industrial"], noise_scale=0.0, multipath=0.0)
    far = plane(3.0)
    depth = far.depth.copy()
    depth[:, BAND] = 1.5
    buffers = replace(far, depth=depth)
    bright, dull = banded(), capture_of(remission=0.6, roughness=0.8)
    near, before = (model.read(buffers, item, np.random.default_rng(1))[:, 200:] for item in (bright, dull))
    both = (near > 0) & (before > 0)
    assert both.mean() > 0.9
    assert np.median((near - before)[both]) < -0.02
