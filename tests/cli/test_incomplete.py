"""A dataset without its final manifest is called incomplete by every command that reads datasets, and none reads it."""

import re
import shutil
from collections.abc import Callable
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


@pytest.fixture
def answer(
    places: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[[str, Path], tuple[int, str]]:
    """Return what gives a command's exit code and the one line that it says of what is wrong with the data."""

    def of(command: str, data: Path) -> tuple[int, str]:
        given = places | {"data": data, "new": tmp_path / "new", "inspected": tmp_path / "inspected"}
        code = main(COMMANDS[command].format_map(given).split())
        out, err = capsys.readouterr()
        said = [line for line in (out + err).splitlines() if re.match("error: |FAIL", line)]
        assert len(said) == 1, (out, err)
        return code, said[0]

    monkeypatch.chdir(tmp_path)
    return of


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("which", ["data", "copied", "data/bop"])
def test_every_command_says_that_it_is_incomplete(command: str, which: str, places: dict[str, Path], answer) -> None:
    data = places["data"].parent / which
    code, said = answer(command, data)
    assert code == (1 if command.startswith("validate") and said.startswith("FAIL") else 2)
    assert "incomplete" in said
    assert str(data) in said
    assert "--resume" in said if which != "copied" else "again" in said


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    ("data", "words"),
    [("loop", "loop: is not a folder"), ("x" * 300, "too long")],
    ids=["a link to itself", "a name that is too long"],
)
def test_what_can_be_no_folder_is_one_line(command: str, data: str, words: str, tmp_path: Path, answer) -> None:
    (tmp_path / "loop").symlink_to("loop")
    code, said = answer(command, Path(data))
    assert code == 2
    assert said.startswith("error: ")
    assert data[:30] in said
    assert words in said
