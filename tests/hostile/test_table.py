"""Sixty mistakes of users and the answer to each: one line with a remedy, never a traceback, never silence."""

import re
import shlex
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import warehouse_sim as ws
from tests.shared import Shared
from warehouse_sim.cli.main import main

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


@cache
def settled() -> Any:
    scene = ws.Scene()
    scene.add("epal1", x=1.0)
    return scene.settle()


def in_millimetres(image: ws.RgbdImage) -> list[ws.PoseEstimate]:
    T = np.eye(4)
    T[2, 3] = 3200.0
    return [ws.PoseEstimate(image.scene_id, image.image_id, 1, 1.0, T)]


def ends(image: ws.RgbdImage) -> list[ws.PoseEstimate]:
    raise SystemExit


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
    ("an unknown preset of a camera", lambda data, at: ws.Rig(camera="d435_720"), "did you mean 'd435_720p'"),
    ("a field of view in radians", lambda data, at: ws.Camera("d435", hfov_deg=1.57), "5-170 degrees"),
    ("a mast below the floor", lambda data, at: ws.Rig(on="forklift", height=-1.0), "height"),
    ("a visible fraction of two", lambda data, at: ws.recipe("smoke", visible=(0.2, 2.0)), "0-1"),
    ("an estimator that is a number", lambda data, at: ws.predict(5, data, split="all"), "estimator"),
    ("an estimator that fails", lambda data, at: ws.Dataset(data).evaluate(lambda image: 1 / 0), "ZeroDivisionError"),
    ("an estimator that returns text", lambda data, at: ws.Dataset(data).evaluate(lambda image: "x"), "PoseEstimate"),
    ("an estimator without a place to go", lambda data, at: ws.predict("front-ft", data), "did you mean 'front-fit'"),
    ("an estimator in millimetres", lambda data, at: ws.Dataset(data).evaluate(in_millimetres), "give metres"),
    ("an estimator that ends the program", lambda data, at: ws.Dataset(data).evaluate(ends), "SystemExit"),
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
    generate = ["generate", str(recipe), "--out", str(out), "--scenes", "1", "--workers", "1"]
    recipe.write_text("extends: smoke\ndescription: x\nscene: {staging: {count: 40}}\n")
    assert main(generate) == 2
    assert "no room for load" in capsys.readouterr().err
    assert out.is_dir()  # the run began, and left what would block the next
    recipe.write_text("extends: smoke\ndescription: x\n")
    assert main(generate) == 0
    said = capsys.readouterr().out
    assert " lx" in said
    assert "above the floor" in said


def test_a_light_preset_replaces_the_light_of_the_recipe_that_is_extended(tmp_path: Path, capsys) -> None:
    bright, dark = tmp_path / "bright.yaml", tmp_path / "dark.yaml"
    bright.write_text("extends: smoke\ndescription: x\nscene: {lights: {preset: nominal, lux: {min: 180, max: 320}}}\n")
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


def test_a_camera_on_a_mast_stands_at_the_height_that_is_asked(tmp_path: Path) -> None:
    recipe = ws.recipe("smoke", sensors=ws.Rig(camera="d435", on="forklift", height=1.2))
    data = ws.generate(recipe, tmp_path / "out", scenes=1, formats="bop")
    heights = [obs.T_world_camera[2, 3] for obs in data]
    assert np.allclose(heights, 1.2)
