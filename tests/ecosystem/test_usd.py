"""NVIDIA's validator and the physics of Isaac Sim take our stages as they are."""

import json
from pathlib import Path

import pytest

from tests.ecosystem.conftest import RunTool
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.interchange import write_usd
from warehouse_sim.schema import SceneSpec

pytestmark = pytest.mark.ecosystem


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[SceneSpec, Path]:
    recipe = load_recipe("smoke")
    scene = prepare_scene(recipe, 0, 0).scene
    return scene, write_usd(scene, tmp_path_factory.mktemp("usd") / "scene.usdc", recipe.sensors)


def test_the_asset_validator_finds_no_failure(written: tuple[SceneSpec, Path], run_tool: RunTool) -> None:
    found = json.loads(run_tool("validate_usd.py", written[1]).splitlines()[-1])
    assert [key for key in found if key.startswith("bad")] == []
    assert {key.split()[1] for key in found} <= {"WeldChecker"}  # our boxes have corners of their own on each face


def test_physx_holds_the_scene_still(written: tuple[SceneSpec, Path], run_tool: RunTool) -> None:
    scene, path = written
    printed = run_tool("simulate_usd.py", path)
    found = json.loads(next(line for line in printed.splitlines() if line.startswith("RESULT")).removeprefix("RESULT"))
    loose = [scene.model_of(item).mass for item in scene.instances if item.dynamic]
    assert found["bodies"] == len(loose)
    assert found["mass"] == pytest.approx(sum(loose), rel=1e-5)
    assert found["drift"] < 0.002
