"""Every example is short, runs as it stands, without arguments, and leaves one picture."""

import re
import runpy
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.estimators.pose.densefusion.made_run import made_run

FOLDER = Path(__file__).resolve().parents[1] / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))
OWN_IMAGE = FOLDER / "09_own_rgbd_frame.py"


def test_there_are_ten_each_shorter_than_fifty_lines() -> None:
    assert [path.name[:3] for path in EXAMPLES] == [f"{number:02d}_" for number in range(1, 11)]
    for path in EXAMPLES:
        text = path.read_text(encoding="utf-8")
        assert len(text.splitlines()) < 50, path.name
        assert f"\npython examples/{path.name}" in text


def run(path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch, *arguments: str) -> None:
    """Run an example in a folder, in this process, where all that it imports is there already."""
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", [str(path), *arguments])
    runpy.run_path(str(path), run_name="__main__")


SLOW = {"07_train_on_stream"}
"""What it calls, a stream and torch's loader, ``tests/api/test_stream.py`` holds."""


@pytest.mark.gl
@pytest.mark.pages
@pytest.mark.parametrize(
    "path", [pytest.param(path, marks=pytest.mark.slow if path.stem in SLOW else (), id=path.stem) for path in EXAMPLES]
)
def test_an_example_runs_says_something_and_leaves_one_picture(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run(path, tmp_path, monkeypatch)
    assert capsys.readouterr().out.strip()
    (picture,) = (tmp_path / "out" / "examples").glob("*.png")
    assert picture.stem == path.stem
    image = cv2.imread(str(picture))
    assert min(image.shape[:2]) > 100
    assert np.std(image) > 10.0


def test_the_pallet_in_ones_own_image_is_estimated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """By a run folder; untrained weights get no nearer than the cloud, which suffices to see that all fits together."""
    weights = made_run(tmp_path / "run", object_name="epal1")
    run(OWN_IMAGE, tmp_path, monkeypatch, str(weights))
    first, *rows = capsys.readouterr().out.splitlines()
    found = re.match(r"epal1 at x (\S+), y (\S+), z (\S+) m; score 0\.\d\d, expected error unknown", first)
    assert found
    place = [float(value) for value in found.groups()]
    assert np.linalg.norm(np.array(place) - [0.73, 0.35, 3.31]) < 1.0
    assert len(rows) == 4
