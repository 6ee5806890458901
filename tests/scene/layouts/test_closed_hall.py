"""A hall of no given size with a roof is closed: walls of 9.00 m under a sheet at 9.24 m leave no strip of sky."""

import numpy as np
import pytest

from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.recipe import SceneRecipe
from warehouse_sim.scene.sampling import sample_scene


@pytest.mark.parametrize("walls", ["panels", "cladding"])
def test_no_ray_leaves_a_hall_with_a_roof(walls: str) -> None:
    hall = {"roof": True, "walls": walls}
    recipe = SceneRecipe.from_plain({"hall": hall, "observations_per_scene": 1}, "recipe")
    scene = sample_scene(recipe, 0, 0)
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(60_000, 3))
    directions[:, 2] = np.abs(directions[:, 2]) * rng.choice([1.0, 0.3, 0.1, 0.03], size=len(directions))
    caster = RayCaster(scene)
    for place in ([0.0, -4.0, 2.0], [-15.0, -12.0, 8.5], [15.0, -3.0, 8.9]):
        hits = caster.cast(np.tile(np.array(place), (len(directions), 1)), directions)
        assert np.isfinite(hits.distance).all()
