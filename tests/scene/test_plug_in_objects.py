"""Objects that a plug-in registers: a recipe can place them with their own materials, and no other recipe notices."""

from pathlib import Path

import pytest

from tests.scene.stranger import install, output_of

RESAMPLES = """
import hashlib
import numpy as np
from warehouse_sim.generation.occlusion.occluder import OccluderSampler
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import sample_scene

recipe = load_recipe("industrial").scene
digest = hashlib.sha256()
for index in range(1):
    for item in sample_scene(recipe, 0, index).instances:
        digest.update(item.model.encode())
        digest.update(np.ascontiguousarray(item.T_world_object).tobytes())
stock = OccluderSampler(recipe.loads, np.random.default_rng(0))
for height in np.linspace(0.3, 2.3, 40):
    occluder = stock.sample("traffic", height)
    digest.update(str(occluder and occluder.instances[0].model).encode())
print(digest.hexdigest())
"""
PLACED = """
from warehouse_sim.config import from_mapping
from warehouse_sim.scene import sample_scene
from warehouse_sim.scene.recipe import SceneRecipe

scene = {
    "layout": {"kind": "rack_aisle", "bays": 1}, "targets": ["pallet", "crate"],
    "traffic": {"objects": ["crate"], "own": 2}, "loads": {"cartons": ["long_carton"], "empty_fraction": 0.0},
}
drawn = sample_scene(from_mapping(SceneRecipe, scene, "own.yaml"), 0, 0)
placed = {item.model for item in drawn.instances}
print(sorted(placed & {"crate", "long_carton"}), drawn.materials["stranger_stripes"].texture)
"""
SAMPLED = """
from dataclasses import replace
from warehouse_sim.catalog import catalog_object
from warehouse_sim.generation.catalog_sheet import render_thumbnail
from warehouse_sim.render import open_renderer

crate = catalog_object("crate")
plain = replace(crate, materials=(replace(crate.materials[0], texture=None),))
with open_renderer("raster") as renderer:
    print(*(render_thumbnail(renderer, model)[110:130, 140:180].std().round(1) for model in (crate, plain)))
"""
REJECTED = """
from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import ConfigError
for name in ("small_number", "unpainted"):
    try:
        catalog_object(name)
    except ConfigError as problem:
        print(problem)
"""


def test_what_is_installed_changes_no_draw_of_a_recipe_that_does_not_name_it(tmp_path: Path) -> None:
    install(tmp_path)
    assert output_of(RESAMPLES, tmp_path) == output_of(RESAMPLES)


def test_a_recipe_places_objects_of_a_plug_in_with_the_materials_that_they_bring(tmp_path: Path) -> None:
    install(tmp_path)
    assert output_of(PLACED, tmp_path) == "['crate', 'long_carton'] stranger:textures/stripes"


@pytest.mark.gl
def test_an_object_of_a_plug_in_is_drawn_with_its_own_texture(tmp_path: Path) -> None:
    install(tmp_path)
    textured, plain = map(float, output_of(SAMPLED, tmp_path).split())
    assert textured > 20.0 > 3.0 * plain


def test_an_object_that_does_not_fit_the_catalog_is_rejected(tmp_path: Path) -> None:
    install(tmp_path)
    small, unpainted = output_of(REJECTED, tmp_path).splitlines()
    assert small.endswith("obj_id must be 1000 or more, found 7")
    assert unpainted.endswith("list its material 'gold' in ObjectModel.materials")
