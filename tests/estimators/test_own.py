"""Estimators of users: files, modules, objects and functions, what they return, and how they fail."""

import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.errors import one_line
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import pose_csv, predictions
from warehouse_sim.errors import EstimatorError, InputError, UnknownNameError, WarehouseSimError
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.predict import predict
from warehouse_sim.schema import PoseEstimate

MINE = """
import numpy as np
from beside import AHEAD
from warehouse_sim import PoseEstimate


class Mine:
    def estimate(self, image):
        T = np.eye(4)
        T[2, 3] = AHEAD
        return [
            PoseEstimate(image.scene_id, image.image_id, 1, 0.5, T, detection=item.number)
            for item in image.detections
        ]


class Failing:
    def estimate(self, image):
        return self.inner(0)

    def inner(self, value):
        return 1 / value


class NeedsWeights:
    def __init__(self, weights):
        self.weights = weights


class NotMade:
    def __init__(self):
        raise OSError("no licence\\nfound")


def by_function(image):
    return Mine().estimate(image)


def two(image, more):
    return []


INSTANCE = Mine()
"""


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a file of estimators, and end what opening it changes."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "beside.py").write_text("AHEAD = 2.5\n", encoding="utf-8")
    monkeypatch.delitem(sys.modules, "beside", raising=False)
    path = tmp_path / "my.py"
    path.write_text(MINE, encoding="utf-8")
    return path


def image(scene_id: int = 4, image_id: int = 7) -> RgbdImage:
    depth, K = np.ones((4, 6)), np.diag([5.0, 5.0, 1.0])
    seen = RgbdImage.from_arrays(depth, K, [Detection(box_xyxy=(1, 1, 3, 3), number=0)])
    return RgbdImage(seen.camera, seen.depth, seen.detections, scene_id=scene_id, image_id=image_id)


@pytest.mark.parametrize("name", ["Mine", "by_function", "INSTANCE"])
def test_a_file_gives_an_estimator_by_class_function_or_object(mine: Path, name: str) -> None:
    estimator = load_estimator(f"{mine}:{name}")
    (found,) = estimator.estimate(image())
    assert (found.scene_id, found.image_id, found.T_camera_object[2, 3]) == (4, 7, 2.5)
    assert estimator.objects is None


def test_a_module_of_the_current_folder_gives_an_estimator(mine: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(mine.parent)
    monkeypatch.delitem(sys.modules, "my", raising=False)
    assert len(load_estimator("my:Mine").estimate(image())) == 1


def test_an_estimator_of_a_file_predicts_every_target(toy_root: Path, mine: Path) -> None:
    estimates = predict(f"{mine}:Mine", toy_root, "train")
    assert estimates
    assert len(estimates) == len(predict("rectangle-fit", toy_root, "train"))
    assert all(item.T_camera_object[2, 3] == 2.5 for item in estimates)


@pytest.mark.parametrize(
    ("name", "kind", "words"),
    [
        ("{my}:Min", UnknownNameError, "unknown class or function of my.py 'Min' (did you mean 'Mine'?)"),
        ("{my}", InputError, "name the class or function in it, as my.py:Mine"),
        ("{my}:", InputError, "name the class or function in it, as my.py:Mine"),
        ("{my}:NeedsWeights", InputError, "missing a required argument: 'weights'; give them defaults"),
        ("{my}:NotMade", EstimatorError, "my.py:NotMade failed when it was made: OSError: no licence found"),
        ("{my}:two", InputError, "is called with the image alone, but missing a required argument: 'more'"),
        ("{my}:np", InputError, "found my.py:np"),
        ("{folder}/gone.py:Mine", InputError, "gone.py: there is no such file; name an existing one"),
        ("{folder}/bad.py:Mine", InputError, "line 2 is not Python"),
        ("{folder}/lacks.py:Mine", InputError, "No module named 'nowhere_at_all'; install what is missing"),
        ("{folder}/raises.py:Mine", EstimatorError, "cannot be imported: ZeroDivisionError: division by zero"),
        ("{folder}/ends.py:Mine", EstimatorError, "cannot be imported: SystemExit: 3"),
        ("no_module_here:Mine", InputError, "no_module_here: there is no such module here"),
        ("front-ft", UnknownNameError, "did you mean 'front-fit'?"),
    ],
)
def test_what_cannot_be_opened_is_said_in_one_line(mine: Path, name: str, kind: type, words: str) -> None:
    (mine.parent / "bad.py").write_text("x = 1\ndef (:\n", encoding="utf-8")
    (mine.parent / "lacks.py").write_text("import nowhere_at_all\n", encoding="utf-8")
    (mine.parent / "ends.py").write_text("raise SystemExit(3)\n", encoding="utf-8")
    (mine.parent / "raises.py").write_text("1 / 0\n", encoding="utf-8")
    with one_line(kind, words):
        load_estimator(name.format(my=mine, folder=mine.parent))


def estimate(scene_id: int = 4, image_id: int = 7, T: Any = None) -> PoseEstimate:
    return PoseEstimate(scene_id, image_id, 1, 1.0, np.eye(4) if T is None else T)


@pytest.mark.parametrize(
    ("returns", "words"),
    [
        (lambda image: None, "what it returns must be a list of PoseEstimate, found None"),
        (lambda image: np.array(3), "what it returns must be a list of PoseEstimate, found array(3)"),
        (lambda image: [np.eye(4)], "estimate 0: must be a PoseEstimate"),
        (lambda image: [estimate(T=2 * np.eye(4))], "T_camera_object must be a rotation and a translation (m)"),
        (lambda image: [estimate(T=np.full((4, 4), np.nan))], "T_camera_object must be a rotation"),
        (lambda image: [estimate(T=np.diag([1, 1, 1, 1.0]) + 3200.0 * np.eye(4, k=3))], "3,200 m away; give metres"),
        (lambda image: [estimate(), estimate(image_id=8)], "estimate 1 is of scene 4, image 8; take image.scene_id"),
    ],
)
def test_what_is_returned_is_checked(returns: Callable[[Any], Any], words: str) -> None:
    with pytest.raises(InputError) as caught:
        load_estimator(returns).estimate(image())
    assert words in str(caught.value)
    assert "<lambda> on scene 4, image 7" in str(caught.value)


def test_a_class_that_ends_the_program_is_named() -> None:
    def leave(image: RgbdImage) -> list[PoseEstimate]:
        raise SystemExit(0)

    with pytest.raises(EstimatorError, match="failed on scene 4, image 7: SystemExit: 0"):
        load_estimator(leave).estimate(image())


def test_a_generator_is_an_estimator_and_what_it_raises_is_named() -> None:
    def finds(image: RgbdImage) -> Iterator[PoseEstimate]:
        yield estimate()
        yield replace(estimate(), score=1 / (image.image_id - 8))

    assert [item.score for item in load_estimator(finds).estimate(image())] == [1.0, -1.0]
    with pytest.raises(EstimatorError, match="finds failed on scene 4, image 8: ZeroDivisionError"):
        load_estimator(finds).estimate(image(image_id=8))


def test_objects_of_users_are_checked() -> None:
    class Named:
        objects = ("epal1",)

        def estimate(self, image: Any) -> list[PoseEstimate]:
            return []

    with pytest.raises(InputError, match="Named: objects must be None or a list of objects with obj_id and name"):
        _ = load_estimator(Named()).objects


@pytest.mark.parametrize("wrong", [3, None, ["front-fit"], np.eye(4)])
def test_no_estimator_is_said(wrong: Any) -> None:
    with pytest.raises(WarehouseSimError, match="an object with estimate"):
        load_estimator(wrong)


def test_a_failing_estimator_shows_the_users_frames_alone(
    toy_root: Path, mine: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    arguments = ["predict", f"{mine}:Failing", "--data", str(toy_root), "--split", "train"]
    assert main([*arguments, "--out", str(tmp_path / "poses.csv")]) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("predicting")]
    assert lines[0] == "Traceback (most recent call last):"
    assert lines[-1] == "error: estimator my.py:Failing failed on scene 0, image 0: ZeroDivisionError: division by zero"
    files = [line for line in lines if line.lstrip().startswith("File ")]
    assert len(files) == 2
    assert all(f'"{mine}"' in line for line in files)
    assert not (tmp_path / "poses.csv").exists()


# An estimator that is another program: JSON lines in and out, and what is wrong with them in one line.


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


DOCUMENT = Path(__file__).parents[2] / "docs" / "estimators.md"


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
