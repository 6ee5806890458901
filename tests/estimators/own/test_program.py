"""An estimator that is another program: JSON lines in and out, and what is wrong with them in one line."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import pose_csv, predictions
from warehouse_sim.estimators.predict import predict

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


CAD = """
import json, sys
for line in sys.stdin:
    image = json.loads(line)
    for item in image["objects"]:
        size = len(open(item["mesh"], "rb").read())
        print(item["obj_id"], item["name"], item["class_name"], round(item["diameter"], 6), size, file=sys.stderr)
    print("", flush=True)
"""


def test_a_program_gets_the_cad(folder: Path, toy_root: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (folder / "cad.py").write_text(CAD)
    assert run_program(toy_root, "--exec", f"{sys.executable} cad.py") == 0
    lines = set(capfd.readouterr().err.splitlines())
    for info in DatasetReader(toy_root).objects.values():
        mesh = info.mesh()
        told = [line.split() for line in lines if line.startswith(f"{info.obj_id} {info.name} ")]
        (words,) = told
        assert words[2] == info.class_name
        assert float(words[3]) == round(info.diameter, 6)
        assert int(words[4]) > 12 * len(mesh.vertices) + 13 * len(mesh.faces)


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


DOCUMENT = Path(__file__).parents[3] / "docs" / "estimators.md"


def test_the_documented_program_finds_every_target(toy_root: Path, tmp_path: Path) -> None:
    blocks = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)
    (example,) = [block for block in blocks if "sys.stdin" in block]
    assert len(example.splitlines()) <= 20
    (tmp_path / "centroid.py").write_text(example, encoding="utf-8")
    out = tmp_path / "poses.csv"
    arguments = ["predict", "--exec", f"{sys.executable} {tmp_path / 'centroid.py'}", "--data", str(toy_root)]
    assert main([*arguments, "--split", "train", "--out", str(out)]) == 0
    found, reader = predictions.read(out), DatasetReader(toy_root)
    gts = {
        (item.scene_id, item.image_id): [target.T_camera_object[:3, 3] for target in item.targets]
        for item in reader.images("train")
    }
    assert len(found) == len(predict("rectangle-fit", toy_root, "train"))
    for item in found:
        away = [np.linalg.norm(item.T_camera_object[:3, 3] - place) for place in gts[item.scene_id, item.image_id]]
        assert min(away) < 0.7


@pytest.mark.parametrize("options", [["--refine", "icp"], ["--reject", "0.1"]])
def test_options_of_networks_are_rejected(
    toy_root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str]
) -> None:
    command = ["predict", "--exec", "cat", "--data", str(toy_root), "--out", str(tmp_path / "p.csv"), *options]
    assert main(command) == 2
    assert options[0] in capsys.readouterr().err
