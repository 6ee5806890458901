"""An estimator that is another program: JSON lines in and out, and what is wrong with them in one line."""

import sys
from pathlib import Path

import pytest

from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import pose_csv

PROGRAM = """
import json, sys
for line in sys.stdin:
    asked = json.loads(line)
    for item in asked["detections"]:
        pose = {"detection": item["detection"], "name": item["name"], "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
        print(json.dumps(pose | {"t": [0.1 * item["detection"], 0, 2.5], "score": 0.5}))
    print(json.dumps({"end": True}), flush=True)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "program.py").write_text(PROGRAM)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_program(toy_root: Path, *words: str) -> int:
    return main(["predict", "--data", str(toy_root), "--out", "e.csv", "--split", "all", *words])


def test_a_program_predicts(folder: Path, toy_root: Path) -> None:
    assert run_program(toy_root, "--exec", f"{sys.executable} program.py") == 0
    rows = pose_csv.read(folder / "e.csv")
    targets = [
        (image.scene_id, image.image_id, item.obj_id)
        for image in DatasetReader(toy_root).images("all")
        for item in image.targets
    ]
    assert [(row.scene_id, row.image_id, row.obj_id) for row in rows] == targets
    assert {row.T_camera_object[2, 3] for row in rows} == {2.5}


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("print('hello', flush=True); input(); input()", "line 1 is no JSON object: 'hello"),
        ("input(); print('{}', flush=True); input()", "line 1 lacks a key or has a wrong value (KeyError: 'R')"),
        ("raise SystemExit(3)", "ended with exit code 3 before all images"),
        ("import time; time.sleep(30)", "no answer to scene 0, image 0 within 1 s"),
    ],
)
def test_a_bad_program_is_named(folder: Path, toy_root: Path, capsys, body: str, words: str) -> None:
    (folder / "bad.py").write_text(body)
    assert run_program(toy_root, "--exec", f"{sys.executable} bad.py", "--exec-timeout", "1") == 2
    assert words in capsys.readouterr().err.splitlines()[-1]


def test_a_csv_is_not_replaced_unasked(folder: Path, toy_root: Path, capsys) -> None:
    (folder / "e.csv").write_text("precious")
    words = ("--exec", f"{sys.executable} program.py")
    assert run_program(toy_root, *words) == 2
    assert "add --overwrite" in capsys.readouterr().err
    assert (folder / "e.csv").read_text() == "precious"
    assert run_program(toy_root, *words, "--overwrite") == 0
