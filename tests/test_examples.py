"""Every example runs as it stands."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.estimators.pose.densefusion.made_run import made_run

FOLDER = Path(__file__).resolve().parents[1] / "examples"
OWN_IMAGE = FOLDER / "own_rgbd_frame.py"
EXAMPLES = sorted(set(FOLDER.glob("*.py")) - {OWN_IMAGE})


@pytest.mark.gl
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs_and_says_something(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out.strip()


def test_the_pallet_in_ones_own_image_is_estimated(tmp_path: Path) -> None:
    """By a run folder; untrained weights get no nearer than the cloud, which suffices to see that all fits together."""
    run = made_run(tmp_path / "run", object_name="epal1")
    first, *rows = output_of(OWN_IMAGE, run).splitlines()
    found = re.match(r"epal1 at x (\S+), y (\S+), z (\S+) m; score 0\.\d\d, expected error unknown", first)
    assert found
    place = [float(value) for value in found.groups()]
    assert np.linalg.norm(np.array(place) - [0.73, 0.35, 3.31]) < 1.0
    assert len(rows) == 4


def output_of(path: Path, *arguments: Path) -> str:
    command = [sys.executable, str(path), *map(str, arguments)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout
