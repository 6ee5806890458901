"""A dataset without its final manifest is called incomplete by every command that reads datasets, and none reads it."""

import re
import shutil
from pathlib import Path

import pytest

from tests.cli.test_extras import WAYS
from tests.dataset.toy import CAMERA, PALLET, make_manifest, write_scene
from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.store import DatasetStore

COMMANDS = {line.split(" --")[0].partition(" {")[0] + str(n): line for n, line in enumerate(WAYS) if "{data}" in line}
COMMANDS["convert"] = "convert {data} --to coco --out {new}"


@pytest.fixture(scope="module")
def places(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    root = tmp_path_factory.mktemp("incomplete")
    store = DatasetStore(root / "data", make_manifest())
    store.begin([PALLET], CAMERA)
    for index in range(3):
        write_scene(store, index)  # all that there is to make, but not finished
    (root / "p.csv").write_text("scene_id,im_id,obj_id,score,R,t,time\n")
    copied = shutil.copytree(root / "data", root / "copied")
    (copied / "manifest.unfinished.json").unlink()  # what a copy may be that was cut off
    return {"data": root / "data", "copied": copied, "run": made_run(root / "run"), "predictions": root / "p.csv"}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("which", ["data", "copied", "data/bop"])
def test_every_command_says_that_it_is_incomplete(
    command: str,
    which: str,
    places: dict[str, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    data = places["data"].parent / which
    given = places | {"data": data, "new": tmp_path / "new", "inspected": tmp_path / "inspected"}
    code = main(COMMANDS[command].format_map(given).split())
    out, err = capsys.readouterr()
    said = [line for line in (out + err).splitlines() if re.match("error: |FAIL", line)]
    assert code == (1 if command.startswith("validate") and said[0].startswith("FAIL") else 2), (out, err)
    assert len(said) == 1
    assert "incomplete" in said[0]
    assert str(data) in said[0]
    assert "--resume" in said[0] if which != "copied" else "again" in said[0]


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    ("data", "words"),
    [("loop", "loop: is not a folder"), ("x" * 300, "too long")],
    ids=["a link to itself", "a name that is too long"],
)
def test_what_can_be_no_folder_is_one_line(
    command: str,
    data: str,
    words: str,
    places: dict[str, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop").symlink_to("loop")
    given = places | {"data": Path(data), "new": tmp_path / "new", "inspected": tmp_path / "inspected"}
    assert main(COMMANDS[command].format_map(given).split()) == 2
    said = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error: ")]
    assert len(said) == 1
    assert data[:30] in said[0]
    assert words in said[0]
