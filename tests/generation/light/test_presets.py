"""Presets can be distinguished in the images: by brightness, contrast, colour, how colour varies, or by noise."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from warehouse_sim.generation.light import light_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.lighting.config import PRESETS, LightingConfig
from warehouse_sim.scene.lighting.exposure import ev_of_exposure
from warehouse_sim.schema import Viewpoint

pytestmark = pytest.mark.gl

CAMERA = PinholeCamera.from_focal(320, 180, 168.0)
VIEW = Viewpoint(level_camera(np.array([-11.0, -6.0, 2.4]), np.deg2rad(10.0)))
NOTICEABLE = {"brightness": 0.35, "contrast": 0.5, "warmth": 0.2, "variety": 0.35, "gain": 1.5}


@pytest.fixture(scope="module")
def statistics(renderer: Renderer) -> dict[str, dict[str, float]]:
    # Without a roof: under one, the ends of a hall that is lit over its aisle alone are dark under every preset.
    recipe = load_recipe("demo")
    recipe = replace(recipe, scene=replace(recipe.scene, hall=replace(recipe.scene.hall, roof=False)))
    scene = replace(sample_settled_scene(recipe, 0, 0).scene, viewpoints=(VIEW,))
    caster, found = RayCaster(scene), {}
    for preset in PRESETS:
        lit = light_scene(scene, LightingConfig(preset=preset), caster, CAMERA, np.random.default_rng(0))
        seen = lit.seen_from(lit.viewpoints[0])
        renderer.load(seen)
        found[preset] = _measure(renderer.render(CAMERA, VIEW.T_world_camera).rgb.astype(float))
        found[preset]["gain"] = -ev_of_exposure(seen.exposure)
    return found


def _measure(rgb: np.ndarray) -> dict[str, float]:
    """Return stops of displayed values: mean, range from dark to bright, red over blue, and how that varies."""
    grey = rgb @ [0.2126, 0.7152, 0.0722]
    dark, middle, bright = np.percentile(grey, [5, 50, 95])
    warmth = np.log2((rgb[..., 0] + 4) / (rgb[..., 2] + 4))[grey > 25]
    return {
        "brightness": float(np.log2(grey.mean())),
        "contrast": float(np.log2((bright + 4) / (dark + 4))),
        "warmth": float(np.median(warmth)),
        "variety": float(np.percentile(warmth, 90) - np.percentile(warmth, 10)),
        "middle": float(middle),
        "white": float((grey > 250).mean()),
    }


@pytest.mark.parametrize(("one", "other"), list(combinations(PRESETS, 2)))
def test_any_two_presets_differ_noticeably(statistics: dict[str, dict[str, float]], one: str, other: str) -> None:
    apart = {name: abs(statistics[one][name] - statistics[other][name]) for name in NOTICEABLE}
    assert any(apart[name] >= limit for name, limit in NOTICEABLE.items()), apart


def test_each_preset_is_what_its_name_says(statistics: dict[str, dict[str, float]]) -> None:
    nominal = statistics["nominal"]
    assert 80 < nominal["middle"] < 160
    assert nominal["contrast"] == min(item["contrast"] for item in statistics.values())
    # The camera lifts it, which is seen as noise.
    assert nominal["brightness"] - 0.5 < statistics["dim"]["brightness"] < nominal["brightness"]
    assert statistics["dim"]["gain"] > nominal["gain"] + 2.0
    assert statistics["harsh"]["contrast"] > nominal["contrast"] + 1.5
    assert statistics["backlit"]["white"] == max(item["white"] for item in statistics.values()) > 0.005
    assert statistics["backlit"]["middle"] < 0.6 * nominal["middle"]
    assert statistics["night"]["middle"] == min(item["middle"] for item in statistics.values()) < 25
    varieties = [item["variety"] for item in statistics.values()]
    assert statistics["mixed_colour"]["variety"] == max(varieties) > nominal["variety"] + 0.4
    assert statistics["failing"]["contrast"] > nominal["contrast"] + 0.6
