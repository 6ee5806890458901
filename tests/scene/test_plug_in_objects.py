"""Objects that a plug-in registers: a recipe can place them with their own materials, and no other recipe notices."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.generation.occlusion.occluder import OccluderSampler
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.scene import sample_scene


def digest() -> str:
    """Return a hash of what the recipe ``smoke`` and the stock of occluders sample."""
    recipe = load_recipe("smoke").scene
    found = hashlib.sha256()
    for item in sample_scene(recipe, 0, 0).instances:
        found.update(item.model.encode())
        found.update(np.ascontiguousarray(item.T_world_object).tobytes())
    stock = OccluderSampler(recipe.loads, np.random.default_rng(0))
    for height in np.linspace(0.3, 2.3, 40):
        occluder = stock.sample("traffic", height)
        found.update(str(occluder and occluder.instances[0].model).encode())
    return found.hexdigest()


WITH_PLUG_IN = """
from tests.scene.test_plug_in_objects import digest
print(digest())

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
from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import ConfigError
for name in ("small_number", "unpainted"):
    try:
        catalog_object(name)
    except ConfigError as problem:
        print(problem)

from dataclasses import replace
from warehouse_sim.generation.catalog_sheet import render_thumbnail
from warehouse_sim.render import open_renderer

crate = catalog_object("crate")
plain = replace(crate, materials=(replace(crate.materials[0], texture=None),))
with open_renderer("raster") as renderer:
    print(*(render_thumbnail(renderer, model)[110:130, 140:180].std().round(1) for model in (crate, plain)))
"""


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Return what a fresh interpreter prints that finds the plug-in."""
    folder = tmp_path_factory.mktemp("plug-in")
    install(folder)
    path = os.pathsep.join([str(folder), *filter(None, sys.path)])
    environment = os.environ | {"PYTHONPATH": path}
    command = [sys.executable, "-c", WITH_PLUG_IN]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.gl
def test_what_is_installed_changes_no_draw_of_a_recipe_that_does_not_name_it(printed: list[str]) -> None:
    assert printed[0] == digest()


@pytest.mark.gl
def test_a_recipe_places_objects_of_a_plug_in_and_those_that_do_not_fit_the_catalog_are_rejected(
    printed: list[str],
) -> None:
    _, placed, small, unpainted, _ = printed
    assert placed == "['crate', 'long_carton'] stranger:textures/stripes"
    assert small.endswith("obj_id must be 1000 or more, found 7")
    assert unpainted.endswith("list its material 'gold' in ObjectModel.materials")


@pytest.mark.gl
def test_an_object_of_a_plug_in_is_drawn_with_its_own_texture(printed: list[str]) -> None:
    textured, plain = map(float, printed[-1].split())
    assert textured > 20.0 > 3.0 * plain


_OBJECTS = """
import numpy as np
from warehouse_sim.catalog.parts import box_part, solid_box
from warehouse_sim.schema import Material, ObjectModel

STRIPES = Material("stranger_stripes", (0.4, 0.4, 0.4), texture="stranger:textures/stripes", texture_size=0.4)
SIZES = {"a_person": (0.4, 0.5, 1.8), "a_cone": (0.3, 0.3, 0.6), "crate": (0.6, 0.4, 0.5)}
SIZES["long_carton"] = (0.4, 0.3, 0.2)
CLASSES = {"a_person": "person", "a_cone": "cone", "crate": "crate", "long_carton": "carton"}


def build(name):
    size = SIZES[name]
    part, box = box_part(size, (0, 0, 0), STRIPES.name), solid_box(size)
    number = 1500 + list(SIZES).index(name)
    return ObjectModel(name, CLASSES[name], number, np.array(size), (part,), (box,), 5.0, materials=(STRIPES,))


def small_number(name):
    return ObjectModel(name, "crate", 7, np.ones(3), (), ())


def unpainted(name):
    return ObjectModel(name, "crate", 1600, np.ones(3), (box_part((1, 1, 1), (0, 0, 0), "gold"),), ())
"""
_ENTRIES = """[warehouse_sim.catalog_objects]
a_person = stranger:build
a_cone = stranger:build
crate = stranger:build
long_carton = stranger:build
small_number = stranger:small_number
unpainted = stranger:unpainted
"""


def install(folder: Path) -> None:
    """Write the package and its metadata into ``folder`` as an installer would."""
    package, info = folder / "stranger", folder / "stranger-1.0.dist-info"
    (package / "textures" / "stripes").mkdir(parents=True)
    (package / "__init__.py").write_text(_OBJECTS)
    stripes = np.where(np.arange(64) // 8 % 2, 230, 20).astype(np.uint8)
    cv2.imwrite(str(package / "textures" / "stripes" / "albedo.png"), np.tile(stripes, (64, 1)))
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: stranger\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(_ENTRIES)
