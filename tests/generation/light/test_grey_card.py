"""A grey card under a known illuminance has the display value of the formula."""

import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import unit_box
from warehouse_sim.geometry.pose import level_camera, make_transform
from warehouse_sim.render import Renderer
from warehouse_sim.scene.lighting.exposure import exposure_of_ev
from warehouse_sim.scene.lighting.photometry import cone_of_beam, light_illuminance
from warehouse_sim.schema import Light, Material, ObjectInstance, ObjectModel, Part, SceneSpec

pytestmark = pytest.mark.gl

CAMERA = PinholeCamera.from_focal(160, 120, 200.0)
CARD = Material("card", (0.18, 0.18, 0.18), roughness=0.2)
LIGHT = np.array([5.0, 0.0, 5.0])


def scene_under(lux: float, ev: float) -> SceneSpec:
    """Lay a card on the ground at the origin, lit from 45 degrees so that its gloss goes elsewhere."""
    part = Part(unit_box(), np.array([1.0, 1.0, 0.02]), np.eye(4), "card")
    model = ObjectModel("card", "card", 1, np.array([1.0, 1.0, 0.02]), (part,), ())
    card = ObjectInstance(1, "card", make_transform(translation=np.array([0.0, 0.0, -0.01])))
    light = Light("spot", LIGHT, -LIGHT / np.linalg.norm(LIGHT), 1.0, (1.0, 1.0, 1.0), *cone_of_beam(90.0))
    per_candela = light_illuminance(light, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))[0]
    light = Light("spot", LIGHT, light.direction, lux / per_candela, light.color, light.cone_inner, light.cone_outer)
    exposure = exposure_of_ev(ev)
    return SceneSpec(0, 0, {"card": model}, {"card": CARD}, (card,), (light,), (), ambient=0.0, exposure=exposure)


def closed_form(lux: float, ev: float) -> float:
    """Albedo / pi * lux is the luminance; 1 / (1.2 * 2^EV) of it the image value; then Narkowicz' ACES fit and sRGB."""
    x = 0.18 / np.pi * lux / (1.2 * 2.0**ev)
    x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    return float(255.0 * (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055))


@pytest.mark.parametrize(
    ("lux", "ev"), [(500.0, 5.0), (500.0, 6.5), (500.0, 8.0), (500.0, 9.5), (50.0, 4.0), (5000.0, 11.0)]
)
def test_a_grey_card_has_the_value_of_the_formula(renderer: Renderer, lux: float, ev: float) -> None:
    renderer.load(scene_under(lux, ev))
    rgb = renderer.render(CAMERA, level_camera(np.array([0.0, 0.0, 2.0]), 0.0, -np.pi / 2)).rgb.astype(float)
    patch = rgb[58:62, 78:82]
    assert np.ptp(patch) <= 2.0
    np.testing.assert_allclose(patch.mean(axis=(0, 1)), closed_form(lux, ev), atol=2.0)
