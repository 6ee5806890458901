"""A path traced dataset whose process was killed goes on where it was stopped, to the bytes of one that was not."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.shared import hashes
from warehouse_sim.cli.main import main

KILLED_IN_SCENE_1 = """
import os, signal, sys
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.store import DatasetStore

write_scene = DatasetStore.write_scene

def killed(self, scene, observations, *more, **named):
    if scene.scene_index == 1:
        next(observations)
        os.kill(os.getpid(), signal.SIGKILL)
    write_scene(self, scene, observations, *more, **named)

DatasetStore.write_scene = killed
main(sys.argv[1:])
"""
RECIPE = """
description: Two scenes of the smoke recipe as a small camera sees them, which paths draw in seconds.
extends: smoke
scene: {observations_per_scene: 2}
sensors: {camera: {width: 96, height: 64, focal_px: 80}, lidar: null}
scenes: 2
"""


@pytest.fixture(scope="module")
def recipe(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("mitsuba", reason="the extra pathtrace is not installed")
    pytest.importorskip("pyoidn", reason="the extra pathtrace is not installed")
    path = tmp_path_factory.mktemp("recipe") / "small.yaml"
    path.write_text(RECIPE)
    return path


def command(recipe: Path, out: Path, *more: str) -> list[str]:
    backend = ["--backend", "pathtrace", "--samples", "2", "--denoise", "--formats", "bop", "--workers", "1"]
    return ["generate", str(recipe), "--out", str(out), *backend, *more]


@pytest.mark.slow
def test_a_killed_run_is_resumed_to_the_bytes_of_one_in_one_go(
    recipe: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = tmp_path / "killed"
    killed = subprocess.run([sys.executable, "-c", KILLED_IN_SCENE_1, *command(recipe, root)], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert [path.name for path in (root / "scenes").iterdir()] == ["000000.json"]
    assert not (root / "manifest.json").exists()
    before = {path: path.stat().st_mtime_ns for path in (root / "bop/train").rglob("*.png")}
    assert before

    # Other paths would give one dataset of two kinds of images.
    assert main([*command(recipe, root, "--resume"), "--backend-options", "seed=1"]) == 2
    assert "begun with a different value of backend_options" in capsys.readouterr().err

    assert main(command(recipe, root, "--resume")) == 0
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert main(command(recipe, tmp_path / "whole")) == 0
    assert hashes(root) == hashes(tmp_path / "whole")
