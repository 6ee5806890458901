"""Rooflights light the floor below them as much as the panes that rays from the floor meet."""

import numpy as np
import pytest

from warehouse_sim.catalog.materials import materials
from warehouse_sim.color import LUMINANCE
from warehouse_sim.generation.light import LightMeter
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.lighting.config import PRESETS
from warehouse_sim.scene.lighting.daylight import PANE, pane_lights
from warehouse_sim.scene.lighting.photometry import floor_points
from warehouse_sim.scene.recipe import SceneRecipe
from warehouse_sim.scene.sampling import sample_scene
from warehouse_sim.schema import SceneSpec

RAYS = 1000


def scene_of(length: float, width: float, height: float, rooflights: bool = True) -> SceneSpec:
    services = {"rooflights": rooflights, "light_lines": True}
    hall = {"roof": True, "outdoors": True, "length": length, "width": width, "height": height, "services": services}
    lights = {"daylight": True, "mounting_height": None}
    recipe = SceneRecipe.from_plain({"hall": hall, "lights": lights, "observations_per_scene": 1}, "recipe")
    return sample_scene(recipe, 3, 0)


@pytest.mark.parametrize("size", [(30.0, 24.0, 9.0), (60.0, 40.0, 11.0)])
def test_the_floor_gets_what_it_sees_of_the_panes(size: tuple[float, float, float]) -> None:
    """E = pi L times the fraction of cosine-weighted rays that meet panes; bars, girders and racks hide the rest."""
    scene = scene_of(*size)
    caster, floor = RayCaster(scene), floor_points(scene)
    up = np.tile([0.0, 0.0, 1.0], (len(floor), 1))
    lux = LightMeter(scene, caster).direct(floor, up, pane_lights(scene, PRESETS["nominal"])).mean()
    radius, angle = np.random.default_rng(0).random((2, RAYS))
    rays = np.stack([np.sqrt(radius) * np.cos(2 * np.pi * angle), np.sqrt(radius) * np.sin(2 * np.pi * angle)], axis=1)
    rays = np.column_stack([rays, np.sqrt(1.0 - radius)])
    hits = caster.cast(np.repeat(floor, RAYS, axis=0), np.tile(rays, (len(floor), 1)))
    pane = materials()[PANE]
    luminance = pane.emission * float(np.array(pane.base_color) @ LUMINANCE)
    seen = float((hits.materials == list(caster.materials).index(PANE)).mean())
    assert seen > 0.0
    assert lux == pytest.approx(np.pi * luminance * seen, rel=0.2)


def test_a_hall_without_rooflights_has_none_of_it() -> None:
    assert pane_lights(scene_of(30.0, 24.0, 9.0, rooflights=False), PRESETS["nominal"]) == ()
