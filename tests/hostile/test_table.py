"""Sixty mistakes of users and the answer to each: one line with a remedy, never a traceback, never silence."""

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import warehouse_sim as ws
from warehouse_sim.cli.main import main

COMMANDS = yaml.safe_load(Path(__file__).with_name("commands.yaml").read_text(encoding="utf-8"))
pytestmark = pytest.mark.gl


@pytest.fixture(scope="module")
def places(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    root = tmp_path_factory.mktemp("hostile")
    data = ws.generate("smoke", root / "data", scenes=1)
    poses = root / "poses.csv"
    ws.predict("rectangle-fit", data, poses, split="all")
    (root / "old.csv").write_text("precious")
    return {"data": root / "data", "poses": poses, "old": root / "old.csv"}


@pytest.mark.parametrize("case", COMMANDS, ids=lambda case: case["line"])
def test_a_wrong_command_gets_a_clear_answer(case: dict[str, Any], places, tmp_path: Path, capsys) -> None:
    code = main(shlex.split(case["line"].format(**places, dir=tmp_path)))
    out, err = capsys.readouterr()
    assert "Traceback" not in err
    assert code == case["code"], (out, err)
    assert case["says"] in out + err
    if code == 2:
        lines = [line for line in err.splitlines() if line.startswith("error: ")]
        assert len(lines) == 1
    assert places["old"].read_text() == "precious"


def settled() -> Any:
    scene = ws.Scene()
    scene.add("epal1", x=1.0)
    return scene.settle()


CALLS: list[tuple[str, Callable[[Path, Path], Any], str]] = [
    ("generate without a name", lambda data, at: ws.generate(5, at / "x"), "recipe"),  # type: ignore[call-overload]
    ("an unknown recipe", lambda data, at: ws.generate("demmo", at / "x"), "did you mean 'demo'"),
    ("no scenes", lambda data, at: ws.generate("smoke", at / "x", scenes=0), "scenes"),
    ("scenes as text", lambda data, at: ws.generate("smoke", at / "x", scenes="two"), "scenes"),  # type: ignore[arg-type]
    ("a dataset that is a number", lambda data, at: ws.Dataset(5), "path"),  # type: ignore[arg-type]
    ("a dataset that is not there", lambda data, at: ws.Dataset(at / "none"), "none"),
    ("an observation by name", lambda data, at: ws.Dataset(data)["x"], "number"),  # type: ignore[call-overload]
    ("an observation too far", lambda data, at: ws.Dataset(data)[10**9], "observation"),
    ("a split that is not there", lambda data, at: ws.Dataset(data).split("tset"), "tset"),
    ("an unknown field", lambda data, at: ws.Dataset(data).torch("rgbd"), "did you mean 'rgb'"),
    ("an unknown object", lambda data, at: ws.Scene().add("epal"), "did you mean 'epal1'"),
    ("an object that is a number", lambda data, at: ws.Scene().add(5), "5"),  # type: ignore[arg-type]
    ("a place that is no number", lambda data, at: ws.Scene().add("epal1", x="a"), "x"),  # type: ignore[arg-type]
    ("a place that is not finite", lambda data, at: ws.Scene().add("epal1", yaw_deg=float("nan")), "yaw_deg"),
    ("an unknown light", lambda data, at: ws.Scene().light("nite"), "night"),  # type: ignore[arg-type]
    ("an unknown camera", lambda data, at: ws.Camera("d453"), "did you mean"),
    ("a camera file that is none", lambda data, at: ws.Camera.from_file(data / "manifest.json"), "manifest.json"),
    ("a picture before the scene has settled", lambda data, at: ws.Scene().render(views=2), "settle"),
    ("a picture from nowhere", lambda data, at: settled().render(), "at and look_at"),
    ("a look at oneself", lambda data, at: settled().render(at=(0, 0, 1), look_at=(0, 0, 1)), "same place"),
    ("an unknown LiDAR", lambda data, at: ws.Rig(lidar="os1_63"), "os1_6"),
    ("a mast below the floor", lambda data, at: ws.Rig(on="forklift", height=-1.0), "height"),
    ("a visible fraction of two", lambda data, at: ws.recipe("smoke", visible=(0.2, 2.0)), "0-1"),
    ("an estimator that is a number", lambda data, at: ws.predict(5, data, split="all"), "estimator"),
    ("an estimator that fails", lambda data, at: ws.Dataset(data).evaluate(lambda image: 1 / 0), "ZeroDivisionError"),
    ("an estimator that returns text", lambda data, at: ws.Dataset(data).evaluate(lambda image: "x"), "PoseEstimate"),
    ("scores of nothing", lambda data, at: ws.evaluate(at / "none.csv", data), "none.csv"),
    ("a report of nothing", lambda data, at: ws.report(out=at / "r.html"), "at least one"),
    ("a format that is not there", lambda data, at: ws.Writer(at / "w", formats=["bopp"]).__enter__(), "bop"),
    ("depth in millimetres", lambda data, at: ws.RgbdImage.from_arrays(np.full((4, 4), 900.0), np.eye(3)), "metres"),
]


@pytest.mark.parametrize(("call", "says"), [pytest.param(call, says, id=name) for name, call, says in CALLS])
def test_a_wrong_call_gets_a_clear_answer(call: Callable[[Path, Path], Any], says: str, places, tmp_path: Path) -> None:
    with pytest.raises(ws.WarehouseSimError) as caught:
        call(places["data"], tmp_path)
    message = str(caught.value)
    assert says in message
    assert len(message.splitlines()) == 1


def test_there_are_sixty_and_a_third_of_them_are_calls() -> None:
    assert len(COMMANDS) + len(CALLS) >= 60
    assert len(CALLS) >= 20


def test_a_failed_run_does_not_block_the_corrected_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recipe, out = tmp_path / "mine.yaml", tmp_path / "out"
    recipe.write_text("extends: smoke\ndescription: x\nscene: {staging: {count: 60}}\n")
    assert main(["generate", str(recipe), "--out", str(out), "--scenes", "1", "--workers", "1"]) == 2
    recipe.write_text("extends: smoke\ndescription: x\n")
    assert main(["generate", str(recipe), "--out", str(out), "--scenes", "1", "--workers", "1"]) == 0
    said = capsys.readouterr().out
    assert " lx" in said
    assert "above the floor" in said


def test_a_camera_on_a_mast_stands_at_the_height_that_is_asked(tmp_path: Path) -> None:
    recipe = ws.recipe("smoke", sensors=ws.Rig(camera="d435", on="forklift", height=1.2))
    data = ws.generate(recipe, tmp_path / "out", scenes=2)
    heights = [obs.T_world_camera[2, 3] for obs in data]
    assert np.allclose(heights, 1.2)
