"""The watch of a long run sees memory that grows, and a run that was stopped goes on."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.speed import long_run
from warehouse_sim.dataset.manifest import read_manifest


def test_memory_that_grows_is_told_from_memory_that_does_not() -> None:
    flat = [(float(second), second, 100.0 + second % 3) for second in range(1, 201)]
    grows = [(float(second), second, 100.0 + second) for second in range(1, 201)]
    assert long_run.summary(flat, 200, 2)["growth"] == pytest.approx(1.0, abs=0.03)
    found = long_run.summary(grows, 200, 2)
    assert found["growth"] > 2.0
    assert found["observations_per_s"] == pytest.approx(2.0)
    assert found["observations"] == 400
    assert found["hours_for_50000"] == pytest.approx(25_000 / 3600)


def test_the_memory_of_children_counts(tmp_path: Path) -> None:
    code = "import subprocess, sys, time; hold = bytearray(64 << 20); print(1, flush=True); time.sleep(60)"
    outer = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {code!r}])"
    with subprocess.Popen([sys.executable, "-c", outer], stdout=subprocess.PIPE, start_new_session=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        assert 64.0 < long_run.resident_mib(process.pid) < 512.0
        os.killpg(process.pid, signal.SIGKILL)


@pytest.mark.gl
@pytest.mark.slow
def test_a_run_that_was_stopped_goes_on(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "benchmarks.speed.long_run", "--folder", str(tmp_path), "--observations", "8"]
    words += ["--workers", "1", "--every-s", "0.2", "--outputs", "depth", "poses"]
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, start_new_session=True) as process:
        while long_run.done_scenes(tmp_path / "data") < 1 and process.poll() is None:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGKILL)
    before = long_run.read_rows(tmp_path / "watched.csv")
    assert before
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    after = long_run.read_rows(tmp_path / "watched.csv")
    assert after[: len(before)] == before
    manifest = read_manifest(tmp_path / "data")
    assert after[-1][1] == manifest.scenes
    assert manifest.contents.outputs == {"depth", "poses"}
    assert [row[0] for row in after] == sorted(row[0] for row in after)
