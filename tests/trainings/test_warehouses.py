"""Parts of warehouses are made by processes that end with the one that started them."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.processes import left_after_kill


@pytest.mark.gl
def test_workers_at_work_end_with_a_killed_parent(tmp_path: Path) -> None:
    words = ["--minutes", "10", "--processes", "1", "--parts", "1", "--folder", str(tmp_path)]
    run = subprocess.Popen([sys.executable, "-m", "trainings.warehouses", *words], stdout=subprocess.DEVNULL)
    while not list(tmp_path.glob("*/manifest.unfinished.json")):
        assert run.poll() is None
        time.sleep(0.05)
    left = left_after_kill(run, 10.0)
    for pid in left:
        os.kill(pid, signal.SIGKILL)
    assert not left
