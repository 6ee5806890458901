import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.dataset.toy import make_dataset, make_manifest
from warehouse_sim.cli.commands import COMMANDS, GROUPS
from warehouse_sim.cli.main import main
from warehouse_sim.resources import model_names


def run(capsys, *arguments: str) -> tuple[int, str, str]:
    """Return exit code, stdout and stderr of a command."""
    try:
        code = main(arguments)
    except SystemExit as stop:
        code = int(stop.code or 0)
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_list_shows_every_kind_of_name(capsys) -> None:
    code, out, _ = run(capsys, "list")
    assert code == 0
    for name in ("demo", "smoke", "epal1", "lidar", "raster", "kitti", "bop"):
        assert name in out


@pytest.mark.parametrize(("chosen", "threads"), [(None, "1"), ("3", "3")])
def test_generate_gives_matrices_one_thread_unless_another_number_is_set(
    capsys, monkeypatch: pytest.MonkeyPatch, chosen: str | None, threads: str
) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", chosen or "")
    if chosen is None:
        monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    assert run(capsys, "generate", "--help")[0] == 0
    assert os.environ["OPENBLAS_NUM_THREADS"] == threads


def test_list_names_every_preset_and_folds_sizes(capsys) -> None:
    _, out, _ = run(capsys, "list")
    for name in ("d435_720p", "os1_64", "night", "forklift_mast", "segment-densefusion-depth", "kraft", "occlusion"):
        assert re.search(rf"(?<![\w-]){name}(?![\w-])", out), name
    assert re.search(r"carton\* \(\d\d\)", out)
    assert len(out.splitlines()) < 60
    _, whole, _ = run(capsys, "list", "objects")
    assert "carton_600x400x300" in whole.split()


def test_list_gives_json(capsys) -> None:
    names = json.loads(run(capsys, "list", "--json")[1])
    assert "carton_600x400x300" in names["objects"]
    assert json.loads(run(capsys, "list", "lidars", "--json")[1]) == {"lidars": names["lidars"]}


def test_list_says_how_well_bundled_weights_do(capsys) -> None:
    _, out, _ = run(capsys, "list", "estimators")
    assert re.search(r"^densefusion-depth +bundled: .*docked \d\d\.\d %", out, re.MULTILINE)


def test_list_names_all_bundled_weights(capsys) -> None:
    names = json.loads(run(capsys, "list", "--json")[1])
    assert {*model_names()} <= {*names["estimators"], *names["detectors"], *names["segmenters"]}
    assert "densefusion-depth-warehouses" in names["estimators"]
    _, out, _ = run(capsys, "list", "detectors")
    assert re.search(r"^detector-rgb-warehouses +bundled: .*AP50 ", out, re.MULTILINE)


def test_a_number_of_thousands_of_digits_gets_one_line(capsys) -> None:
    code, _, err = run(capsys, "generate", "demo", "--out", "x", "--scenes", "9" * 5001)
    assert code == 2
    (line,) = err.splitlines()
    assert line.startswith("error: ")
    assert "has 5001 digits, which no option takes" in line


def test_help_groups_the_commands_and_version_is_a_line(capsys) -> None:
    code, out, _ = run(capsys, "--help")
    assert code == 0
    assert len(COMMANDS) <= 16
    assert all(re.search(rf"^  {name} ", out, re.MULTILINE) for name in COMMANDS)
    assert [line for line in out.splitlines() if line.endswith(":") and not line.startswith(" ")] == [
        f"{title}:" for title in GROUPS.values()
    ]
    assert re.fullmatch(r"warehouse-sim \d+\.\d+\.\d+\n", run(capsys, "--version")[1])


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_every_command_explains_itself_plainly(capsys, command) -> None:
    code, out, _ = run(capsys, command, "--help")
    assert code == 0
    assert f"warehouse-sim {command}" in out
    assert not re.search(r"\bSTR\b|\bINT\b|\{None\}|None\)|╭", out)
    assert out.count("\n  warehouse-sim ") == 2  # its examples


def test_what_a_format_cannot_hold_is_rejected_before_there_is_a_folder(capsys, monkeypatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    Path("blind.yaml").write_text("extends: smoke\nsensors: {lidar: null}\nsplit: {stratify: [lux]}")
    code, _, err = run(capsys, "generate", "blind.yaml", "--out", "data", "--formats", "kitti")
    assert code == 2
    assert "error: KITTI: sensors.lidar is null, but every KITTI frame has a sweep" in err
    assert [path.name for path in tmp_path.iterdir()] == ["blind.yaml"]


def test_validate_shows_progress_and_says_what_generating_again_would_do(capsys, tmp_path: Path) -> None:
    root = make_dataset(tmp_path / "data")
    code, out, err = run(capsys, "validate", str(root))
    assert code == 0
    fractions = [int(found) for found in re.findall(r"^validate: (\d+)%", err, re.MULTILINE)]
    assert fractions == sorted(fractions)
    assert fractions[0] == 0
    assert fractions[-1] == 100
    (root / "kitti/training/velodyne_ids/000000.bin").unlink()
    code, out, _ = run(capsys, "validate", str(root))
    assert code == 1
    assert "that gives\n        the same bytes: report the lines above" in out
    (root / "bop/train/000000/scene_gt.json").write_text("{")
    _, out, _ = run(capsys, "validate", str(root))
    assert "scene_gt.json: is not valid JSON" in out
    assert "run 'warehouse-sim validate'" not in out


@pytest.mark.parametrize(
    ("scenes", "formats", "next_command"),
    [
        (3, ("kitti", "bop"), "train densefusion-pointcloud --data {root} --out {root}-run"),
        (1, ("bop",), "view {root} --summary"),
        (3, ("coco",), "view {root} --summary"),
        (3, ("yolo",), "view {root} --summary"),
        (3, ("ply",), None),
    ],
)
def test_validate_names_a_command_that_works(
    capsys, tmp_path: Path, scenes: int, formats: tuple[str, ...], next_command: str | None
) -> None:
    root = make_dataset(tmp_path / "data", make_manifest(scenes, formats))
    code, out, _ = run(capsys, "validate", str(root))
    assert code == 0
    said = [line.removeprefix("next:   warehouse-sim ") for line in out.splitlines() if line.startswith("next:")]
    assert said == ([] if next_command is None else [next_command.format(root=root)])
    if said and said[0].startswith("view"):
        assert run(capsys, *said[0].split())[0] == 0


def test_validate_says_that_a_folder_is_a_part_of_a_dataset(capsys, tmp_path: Path) -> None:
    root = make_dataset(tmp_path / "data")
    code, _, err = run(capsys, "validate", str(root / "kitti"))
    assert code == 0
    assert f"warning: {root / 'kitti'} is a part of a dataset; to check all of it, name {root}" in err
    assert "warning" not in run(capsys, "validate", str(root))[2]


@pytest.mark.parametrize("module", ["warehouse_sim.schema", "warehouse_sim.cli.main"])
def test_importing_loads_nothing_heavy(module) -> None:
    heavy = ("torch", "mujoco", "moderngl", "embreex", "open3d", "matplotlib")
    code = f"import sys, {module}; loaded = [m for m in {heavy} if m in sys.modules]; assert not loaded, loaded"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_module_and_script_are_the_same_program() -> None:
    result = subprocess.run([sys.executable, "-m", "warehouse_sim", "list"], check=True, capture_output=True, text=True)
    assert "recipes" in result.stdout


def test_listing_names_loads_nothing_slow() -> None:
    slow = ("scipy", "torch", "mujoco", "moderngl", "open3d", "matplotlib", "pandas")
    run = "from warehouse_sim.cli.main import main; main(['list'])"
    code = f"import sys; {run}; loaded = [m for m in {slow} if m in sys.modules]; assert not loaded, loaded"
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)
