"""Two runs in one folder: the second is rejected and touches nothing, and a killed one frees it for the next."""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.shared import Shared, hashes
from warehouse_sim.cli.main import main
from warehouse_sim.one_writer import LOCK


def wait_for(path: Path) -> None:
    deadline = time.monotonic() + 120.0
    while not path.exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    assert path.exists()


@pytest.mark.gl
def test_a_second_run_is_rejected_and_one_after_a_kill_makes_the_same_bytes(
    shared: Shared, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = tmp_path / "data"
    command = ["generate", str(shared.bare), "--out", str(root), "--workers", "1", "--scenes", "3", "--resume"]
    command += ["--formats", "bop"]
    first = subprocess.Popen([sys.executable, "-m", "warehouse_sim", *command], stderr=subprocess.DEVNULL)
    wait_for(root / "scenes" / "000000.json")
    first.send_signal(signal.SIGSTOP)  # in the middle of its second scene, for as long as it takes
    before = hashes(root)
    assert main(command) == 2
    text = capsys.readouterr().err
    (line,) = [line for line in text.splitlines() if line.startswith("error")]
    assert re.fullmatch(rf"error: .*data: process {first.pid} on \S+ is writing there; .*", line)
    assert "Traceback" not in text
    assert hashes(root) == before
    first.kill()
    first.communicate()
    assert (root / LOCK).is_file()
    assert main(command) == 0
    assert not (root / LOCK).exists()
    assert hashes(root) == hashes(shared.dataset(shared.bare, scenes=3, formats=("bop",)))
