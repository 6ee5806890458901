"""Every shipped recipe becomes a dataset that holds its own checks."""

from dataclasses import replace
from pathlib import Path

import pytest

from warehouse_sim.dataset.validate import validate
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.resources import recipe_names

pytestmark = pytest.mark.gl

QUICK = "demo"
# Their first scenes are those of the recipe that they extend; that of smoke is checked in test_generate.py.
DONE_ELSEWHERE = ("industrial_more", "smoke")
# KITTI is written through a level camera, which does not see straight down.
FROM_ABOVE = ("overhead",)
NAMES = [name for name in recipe_names() if name not in DONE_ELSEWHERE]


@pytest.mark.parametrize(
    ("name", "scenes"), [(QUICK, 1), *[pytest.param(item, 3, marks=pytest.mark.slow) for item in NAMES]]
)
def test_a_small_dataset_of_each_recipe_is_valid(name: str, scenes: int, tmp_path: Path) -> None:
    recipe = load_recipe(name)
    small = replace(recipe, scene=replace(recipe.scene, observations_per_scene=2))
    # A fallen carton has a pose, but no box of KITTI's; and every KITTI frame has a sweep.
    only_bop = "carton" in recipe.scene.targets or name in FROM_ABOVE or recipe.sensors.lidar is None
    formats = ("bop",) if only_bop else ("kitti", "bop")
    generate(small, tmp_path / "data", GenerateConfig(scenes=scenes, seed=1, formats=formats))
    assert [check for check in validate(tmp_path / "data") if not check.ok] == []
