"""Two runs in one folder: the second is rejected and touches nothing, and a killed one frees it for the next."""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.shared import Shared, hashes
from warehouse_sim.one_writer import LOCK


def start(recipe: Path, root: Path) -> subprocess.Popen:
    command = [sys.executable, "-m", "warehouse_sim", "generate", str(recipe), "--out", str(root), "--workers", "1"]
    command += ["--scenes", "2", "--resume", "--formats", "bop"]
    return subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)


def wait_for(path: Path) -> None:
    deadline = time.monotonic() + 120.0
    while not path.exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    assert path.exists()


@pytest.mark.gl
def test_a_second_run_is_rejected_and_one_after_a_kill_makes_the_same_bytes(shared: Shared, tmp_path: Path) -> None:
    root = tmp_path / "data"
    first = start(shared.small, root)
    wait_for(root / "scenes" / "000000.json")
    first.send_signal(signal.SIGSTOP)  # in the middle of its second scene, for as long as it takes
    before = hashes(root)
    rejected = start(shared.small, root)
    _, text = rejected.communicate(timeout=120)
    assert rejected.returncode == 2
    (line,) = [line for line in text.splitlines() if line.startswith("error")]
    assert re.fullmatch(rf"error: .*data: process {first.pid} on \S+ is writing there; .*", line)
    assert "Traceback" not in text
    assert hashes(root) == before
    first.kill()
    first.communicate()
    assert (root / LOCK).is_file()
    again = start(shared.small, root)
    assert (again.communicate(timeout=300)[1], again.returncode)[1] == 0
    assert not (root / LOCK).exists()
    assert hashes(root) == hashes(shared.dataset(shared.small, scenes=2, formats=("bop",)))
