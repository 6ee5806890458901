"""GLB files before the Khronos glTF validator, the npm package gltf-validator."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.ecosystem.conftest import TOOLS
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.interchange import write_glb

pytestmark = pytest.mark.ecosystem


@pytest.mark.parametrize("name", ["smoke", "block_storage"])
def test_the_validator_finds_no_fault(tmp_path: Path, name: str) -> None:
    folder, node = os.environ.get("WAREHOUSE_SIM_GLTF_VALIDATOR"), shutil.which("node")
    if not folder or not Path(folder).is_dir() or node is None:
        pytest.skip("WAREHOUSE_SIM_GLTF_VALIDATOR is not the folder of the npm package, or there is no node")
    recipe = load_recipe(name)
    path = write_glb(prepare_scene(recipe, 0, 0).scene, tmp_path / "scene.glb", recipe.sensors)
    command = [node, str(TOOLS / "validate_gltf.cjs"), str(Path(folder).resolve()), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
    report = json.loads(done.stdout)
    assert report["issues"]["numErrors"] == 0, report["issues"]["messages"][:5]
    assert report["issues"]["numWarnings"] == 0, report["issues"]["messages"][:5]
    # Notes: pictures of labels have the sizes of labels, which are no powers of two.
    assert {item["code"] for item in report["issues"]["messages"]} <= {"IMAGE_NPOT_DIMENSIONS"}
    assert report["info"]["extensionsUsed"] == ["KHR_materials_emissive_strength", "KHR_lights_punctual"]
