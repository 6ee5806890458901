"""Two runs in one folder: the second is rejected, and what the first makes is whole."""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.generation.test_generate import hashes
from warehouse_sim.dataset.validate import validate
from warehouse_sim.one_writer import LOCK

pytestmark = pytest.mark.gl


def start(root: Path) -> subprocess.Popen:
    command = [sys.executable, "-m", "warehouse_sim", "generate", "smoke", "--out", str(root), "--workers", "1"]
    command += ["--scenes", "2", "--resume", "--formats", "bop"]
    return subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)


def wait_for(path: Path) -> None:
    deadline = time.monotonic() + 120.0
    while not path.exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    assert path.exists()


def test_a_second_resume_is_rejected_and_the_first_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    root = tmp_path / "data"
    first = start(root)
    wait_for(root / "scenes" / "000000.json")
    first.send_signal(signal.SIGSTOP)  # in the middle of its second scene, for as long as it takes
    rejected = start(root)
    _, text = rejected.communicate(timeout=120)
    first.send_signal(signal.SIGCONT)
    assert rejected.returncode == 2
    (line,) = [line for line in text.splitlines() if line.startswith("error")]
    assert re.fullmatch(rf"error: .*data: process {first.pid} on \S+ is writing there; .*", line)
    assert "Traceback" not in text
    assert (first.communicate(timeout=300)[1], first.returncode)[1] == 0
    assert [check for check in validate(root) if not check.ok] == []
    alone = start(tmp_path / "alone")
    alone.communicate(timeout=300)
    assert hashes(root) == hashes(tmp_path / "alone")


def test_a_killed_run_frees_the_folder_for_the_next(tmp_path: Path) -> None:
    root = tmp_path / "data"
    killed = start(root)
    wait_for(root / "scenes" / "000000.json")
    killed.kill()
    killed.communicate()
    assert (root / LOCK).is_file()
    again = start(root)
    assert (again.communicate(timeout=300)[1], again.returncode)[1] == 0
    assert not (root / LOCK).exists()
