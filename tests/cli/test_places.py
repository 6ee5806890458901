"""Where a command cannot write, it says so in one line: no traceback, nothing else touched."""

import errno
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.dataset.formats.test_external_bop import write_folder
from tests.dataset.toy import make_dataset
from tests.estimators.pose.densefusion.made_run import made_run
from tests.shared import Shared
from warehouse_sim.cli.main import main

FOLDER_COMMANDS = {
    "generate": "generate smoke --scenes 1 --workers 1",
    "convert": "convert {theirs} --to bop",
    "summary": "view {data} --summary",
    "train": "train densefusion-pointcloud --data {data} --cache none",
    "evaluate": "evaluate {predictions} --data {data}",
    "demo": "demo --recipe smoke",
}
FILE_COMMANDS = {
    "sheet": "list objects epal1",
    "preview": "preview {small}",
    "predict": "predict {run} --data {data}",
    "report": "report {data}",
}
FOLDERS = ("{at}/file", "{at}/file/below", "{at}/dangling", "{at}/dangling/below", "/proc/x")
FILES = ("{at}/folder", "{at}/file/below", "{at}/dangling/below", "/proc/x/y", "/dev/full")
DRAWN = ("sheet", "preview")
"""What is drawn before a file is opened, which takes long; all files are written by one function."""


@pytest.fixture(scope="module")
def made(shared: Shared, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    root = tmp_path_factory.mktemp("made")
    data, run = make_dataset(root / "data"), made_run(root / "run")
    assert main(shlex.split(f"predict {run} --data {data} --out {root / 'p.csv'}")) == 0
    places = {"data": data, "run": run, "predictions": root / "p.csv", "theirs": write_folder(root / "theirs")}
    return places | {"small": shared.small}


@pytest.fixture
def at(tmp_path: Path) -> Path:
    (tmp_path / "file").write_text("precious")
    (tmp_path / "folder").mkdir()
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    return tmp_path


def rejection(capsys: pytest.CaptureFixture[str], line: str) -> str:
    """Run a command that must fail and return its one line."""
    capsys.readouterr()
    assert main(shlex.split(line)) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error: ")]
    return line


@pytest.mark.gl
@pytest.mark.parametrize(
    ("line", "place"),
    [(command, place) for command in FOLDER_COMMANDS.values() for place in FOLDERS]
    + [(command, place) for name, command in FILE_COMMANDS.items() for place in FILES[: 1 if name in DRAWN else None]],
)
def test_a_place_that_cannot_be_written_is_named(capsys, made, at: Path, line: str, place: str) -> None:
    place = place.format(at=at)
    line = rejection(capsys, f"{line.format(**made)} --out {place}")
    assert str(Path(place).parent) in line
    assert "cannot be written" in line
    assert (at / "file").read_text() == "precious"
    assert not (at / "nowhere").exists()
    assert Path("/dev/full").is_char_device()


@pytest.mark.gl
@pytest.mark.parametrize(
    "line", [*FOLDER_COMMANDS.values(), *FILE_COMMANDS.values()], ids=[*FOLDER_COMMANDS, *FILE_COMMANDS]
)
@pytest.mark.parametrize(("function", "number"), [("mkdir", errno.EROFS), ("replace", errno.ENOSPC)])
def test_what_the_system_rejects_is_told(capsys, monkeypatch, made, tmp_path, line, function, number) -> None:
    """A disk that cannot be written, and one that is full."""

    def rejected(*_: object, **__: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, function, rejected)
    line = rejection(capsys, f"{line.format(**made)} --out {tmp_path / 'new' / 'out'}")
    assert f"cannot be written ({os.strerror(number)})" in line


FULL = """
import resource, sys
from warehouse_sim.cli.main import main
most, line = resource.getrlimit(resource.RLIMIT_FSIZE)[1], sys.argv[1].split()
for limit in map(int, sys.argv[2:]):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
    code = main([*line, str(limit)])
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    print(code, flush=True)
"""


@pytest.mark.gl
@pytest.mark.parametrize(
    ("command", "limits"),
    [pytest.param("train", ["20000"], marks=pytest.mark.slow), ("generate", ["3000", "20000"])],
)
def test_a_disk_that_takes_no_more_ends_the_run_in_one_line(made, tmp_path: Path, command: str, limits) -> None:
    """The system's own limit on the size of files stands for a full disk, libraries' files included."""
    more = "--max-steps 6 --batch 4 --validations 3" if command == "train" else ""
    line = f"{FOLDER_COMMANDS[command].format(**made)} {more} --out"
    words = [sys.executable, "-c", FULL, line, *limits]
    run = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
    assert [line for line in run.stdout.splitlines() if line.isdigit()] == ["2"] * len(limits), run.stderr
    lines = [line for line in run.stderr.splitlines() if line.startswith("error: ")]
    assert len(lines) == len(limits)
    assert all("cannot be written (File too large); free some space" in line for line in lines)
    assert "Traceback" not in run.stderr


@pytest.mark.slow
def test_nothing_is_said_when_the_reader_has_seen_enough() -> None:
    script = f"{shlex.quote(sys.executable)} -m warehouse_sim list | head -c 1"
    run = subprocess.run(["bash", "-c", script], capture_output=True, text=True)
    assert len(run.stdout) == 1
    assert run.stderr == ""


def test_a_closed_pipe_is_not_written_to_again(made, capfd) -> None:
    code = f"import sys; from warehouse_sim.cli.main import main; sys.exit(main(['validate', {str(made['data'])!r}]))"
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    assert process.wait() == 141
    told = process.stderr.read()  # progress only
    assert all(line.startswith(b"validate: ") for line in told.splitlines()), told
