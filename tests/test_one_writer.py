"""A folder has one writer at a time, whose lock the system frees."""

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from warehouse_sim import one_writer as module
from warehouse_sim.errors import OutputError
from warehouse_sim.one_writer import LOCK, one_writer

HOLDER = """
import sys
from pathlib import Path
from warehouse_sim.one_writer import one_writer
with one_writer(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.readline()
"""


def start_holder(folder: Path) -> subprocess.Popen:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", HOLDER, str(folder)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    return process


def test_another_process_is_rejected_and_told_who_writes(tmp_path: Path) -> None:
    folder = tmp_path / "data"
    process = start_holder(folder)
    with pytest.raises(OutputError, match=rf"data: process {process.pid} on .* is writing there"), one_writer(folder):
        pass
    assert (folder / LOCK).is_file()  # the rejected one has not taken the other's away
    process.communicate("\n")
    assert not folder.exists()  # nothing came of it
    with one_writer(folder):
        (folder / "written").touch()
    assert [path.name for path in folder.iterdir()] == ["written"]


def test_the_death_of_the_writer_frees_the_folder(tmp_path: Path) -> None:
    process = start_holder(tmp_path)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert (tmp_path / LOCK).is_file()
    with one_writer(tmp_path), pytest.raises(OutputError, match=f"process {os.getpid()}"), one_writer(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_lock_that_its_holder_removed_in_between_is_taken_again(tmp_path: Path, monkeypatch) -> None:
    hold, seen = module._hold, []

    def removed_at_first(number: int, path: Path) -> None:
        hold(number, path)
        if not seen:
            path.unlink()
        seen.append(number)

    monkeypatch.setattr(module, "_hold", removed_at_first)
    with one_writer(tmp_path):
        assert len(seen) == 2
        monkeypatch.undo()
        with pytest.raises(OutputError, match="is writing there"), one_writer(tmp_path):
            pass


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS])
def test_a_file_system_without_locks_is_written_with_a_warning(tmp_path: Path, monkeypatch, caplog, number) -> None:
    def reject(*_: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(module.fcntl, "flock", reject)
    with one_writer(tmp_path):
        pass
    assert "its file system has no locks" in caplog.text
    assert "see to it that no other process writes there" in caplog.text


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for name in ("file", "x" * 300):
        with pytest.raises(OutputError, match="cannot be written"), one_writer(tmp_path / name):
            pass
