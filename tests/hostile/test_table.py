"""Sixty mistakes of users and the answer to each: one line with a remedy, never a traceback, never silence.

Those of Python calls are in the tables of ``tests/api``.
"""

import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import warehouse_sim as ws
from tests.shared import Shared
from warehouse_sim.cli.main import main
from warehouse_sim.generation.recipe import changed, load_recipe

COMMANDS = yaml.safe_load(Path(__file__).with_name("commands.yaml").read_text(encoding="utf-8"))
pytestmark = pytest.mark.gl


@pytest.fixture(scope="module")
def places(shared: Shared, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    root, data = tmp_path_factory.mktemp("hostile"), shared.dataset(scenes=1)
    poses = root / "poses.csv"
    ws.predict("rectangle-fit", data, poses, split="all")
    (root / "old.csv").write_text("precious")
    (root / "mine.py").write_text("class Mine:\n    def estimate(self, image):\n        return []\n")
    header, *rows = poses.read_text().splitlines()
    (root / "metres.csv").write_text("\n".join([header, *map(in_metres, rows), ""]))
    files = {"poses": poses, "metres": root / "metres.csv", "old": root / "old.csv", "mine": root / "mine.py"}
    small = load_recipe(str(shared.small))
    for name, outputs in (("unmasked", ["poses"]), ("colourless", ["depth", "masks", "poses"])):
        recipe = changed(small, {"sensors": {"outputs": outputs}})
        files[name] = shared.dataset(recipe, scenes=1, seed=3, formats=("bop", "bop_webdataset", "bop_compact"))
    return {"data": data, **files}


def in_metres(row: str) -> str:
    """Return a row of a BOP pose CSV with its translation in metres."""
    *first, t, time = row.split(",")
    return ",".join([*first, " ".join(str(float(value) / 1000.0) for value in t.split()), time])


@pytest.mark.parametrize("case", COMMANDS, ids=lambda case: f"{case.get('recipe', '')} {case['line']}".strip())
def test_a_wrong_command_gets_a_clear_answer(case: dict[str, Any], places, tmp_path: Path, capsys) -> None:
    if "recipe" in case:
        (tmp_path / "r.yaml").write_text(f"extends: smoke\ndescription: x\n{case['recipe']}\n")
    code = main(shlex.split(case["line"].format(**places, dir=tmp_path)))
    out, err = capsys.readouterr()
    assert "Traceback" not in err
    assert code == case["code"], (out, err)
    assert case["says"] in out + err
    if code == 2:
        lines = [line for line in err.splitlines() if line.startswith("error: ")]
        assert len(lines) == 1
    assert places["old"].read_text() == "precious"
    assert (places["data"] / "manifest.json").is_file()


def test_there_are_sixty() -> None:
    assert len(COMMANDS) >= 60


def test_a_failed_run_does_not_block_the_corrected_one(
    shared: Shared, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recipe, out = tmp_path / "mine.yaml", tmp_path / "out"
    generate = ["generate", str(recipe), "--out", str(out), "--scenes", "1", "--workers", "1"]
    recipe.write_text(f"extends: {shared.small}\ndescription: x\nscene: {{staging: {{count: 40}}}}\n")
    assert main(generate) == 2
    assert "no room for load" in capsys.readouterr().err
    assert out.is_dir()  # the run began, and left what would block the next
    recipe.write_text(f"extends: {shared.small}\ndescription: x\n")
    assert main(generate) == 0
    said = capsys.readouterr().out
    assert " lx" in said
    assert "above the floor" in said


def test_a_light_preset_replaces_the_light_of_the_recipe_that_is_extended(
    shared: Shared, tmp_path: Path, capsys
) -> None:
    bright, dark = tmp_path / "bright.yaml", tmp_path / "dark.yaml"
    lights = "{lights: {preset: nominal, lux: {min: 180, max: 320}}}"
    bright.write_text(f"extends: {shared.small}\ndescription: x\nscene: {lights}\n")
    dark.write_text("extends: bright.yaml\ndescription: x\nscene: {lights: {preset: night}}\n")
    assert main(["generate", str(dark), "--out", str(tmp_path / "out"), "--scenes", "1", "--workers", "1"]) == 0
    (lux,) = re.findall(r"^floor: +([\d.]+)(?: to [\d.]+)? lx", capsys.readouterr().out, re.MULTILINE)
    assert 0.3 < float(lux) <= 2.0


def test_angles_that_look_like_radians_are_warned_of(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    angles = "{staging: {yaw_deg: {min: -3.1416, max: 3.14}}, viewpoints: {approach_deg: {min: -20, max: 1.0}}}"
    (tmp_path / "r.yaml").write_text(f"extends: smoke\ndescription: x\nscene: {angles}\n")
    assert main(["preview", str(tmp_path / "r.yaml"), "--check"]) == 0
    ws.Scene().add("epal1", yaw_deg=1.5708)
    warned = [record.getMessage() for record in caplog.records if "radians" in record.getMessage()]
    assert len(warned) == 3
    assert "yaw_deg: max: 3.14 looks like radians and is taken for degrees; 180 degrees?" in warned[1]
    assert "90 degrees?" in warned[2]


def test_a_camera_on_a_mast_stands_at_the_height_that_is_asked(shared: Shared, tmp_path: Path) -> None:
    recipe = ws.recipe(shared.bare, sensors=ws.Rig(camera="d435", on="forklift", height=1.2))
    data = ws.generate(recipe, tmp_path / "out", scenes=1, formats="bop")
    heights = [obs.T_world_camera[2, 3] for obs in data]
    assert np.allclose(heights, 1.2)
