import numpy as np
import pytest

from tests.sensors.targets import CAMERA, capture_of
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.sensors.surfaces import returned_light, see_surfaces


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
