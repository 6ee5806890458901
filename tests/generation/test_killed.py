"""Killed anywhere, as often as you like: what --resume makes is what an undisturbed run makes, and nothing runs on."""

import logging
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest

from tests.processes import command_line, descendants, is_alive, scene_workers
from tests.shared import Shared, hashes

pytestmark = [pytest.mark.gl, pytest.mark.slow]

MOMENTS = int(os.environ.get("WAREHOUSE_SIM_KILLS", "30"))
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
_log = logging.getLogger(__name__)
FORMATS = ("kitti", "bop", "bop_webdataset", "coco")


def command(recipe: Path, root: Path) -> list[str]:
    words = [sys.executable, "-m", "warehouse_sim", "generate", str(recipe), "--out", str(root)]
    return [*words, "--scenes", "6", "--workers", "2", "--resume", "--formats", *FORMATS]


def start(recipe: Path, root: Path) -> subprocess.Popen:
    return subprocess.Popen(
        command(recipe, root), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def files(root: Path) -> int:
    return sum(len(names) for _, _, names in os.walk(root))


def wait_for_files(process: subprocess.Popen, root: Path, count: int) -> bool:
    """Return whether the process still ran when there were so many files."""
    while process.poll() is None:
        if files(root) >= count:
            return True
        time.sleep(0.01)
    return False


def strike(rng: random.Random, process: subprocess.Popen) -> str:
    """Send a random signal to the process, to one of its workers, or to all as a terminal does; return which."""
    victim, number = rng.choice(("parent", "worker", "all")), rng.choice(SIGNALS)
    if victim == "all":
        os.killpg(process.pid, number)
    else:
        workers = scene_workers(process.pid)
        victim = "worker" if victim == "worker" and workers else "parent"
        os.kill(rng.choice(workers) if victim == "worker" else process.pid, number)
    return f"{number.name} to {victim}"


def end(process: subprocess.Popen, started: set[int]) -> str:
    """Wait for the process, and for those that it started; return what it said."""
    _, said = process.communicate(timeout=900)
    deadline = time.monotonic() + 10.0
    while (left := set(filter(is_alive, started))) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert left == set(), [command_line(pid) for pid in left]
    return said


def test_thirty_kills_lose_nothing_and_leave_nothing(shared: Shared, tmp_path: Path) -> None:
    whole, root = tmp_path / "whole", tmp_path / "data"
    undisturbed = start(shared.small, whole)
    assert (end(undisturbed, set()), undisturbed.returncode)[1] == 0
    expected, most = hashes(whole), files(whole)
    rng, done, finished = random.Random(21), Counter[str](), 0
    while sum(done.values()) < MOMENTS:
        process = start(shared.small, root)
        # Files are counted, not seconds: a slow machine is struck at the same moments as a fast one.
        first = files(root)
        if wait_for_files(process, root, rng.randint(first, max(first, most))):
            time.sleep(rng.uniform(0.0, 0.05))
            started = descendants(process.pid)
            done[strike(rng, process)] += 1
            _log.info("%d: %d files, %s", sum(done.values()), files(root), dict(done))
        else:
            started = set()
        said = end(process, started)
        assert "Traceback" not in said, (done, said)
        complete = (root / "manifest.json").is_file()
        assert complete or process.returncode != 0, (done, said)
        if complete:
            assert hashes(root) == expected, done
            shutil.rmtree(root)
            finished += 1
    last = start(shared.small, root)
    assert (end(last, set()), last.returncode)[1] == 0
    assert hashes(root) == expected
    _log.info("%s; %d times to the end", dict(done), finished + 1)


FULL = """\
set -e
mount -t tmpfs -o size=$SMALL tmpfs "$DIR"
set +e
"$@" 2> "$LOG.full"; echo $? > "$LOG.full.code"
mount -o remount,size=512m,ro "$DIR"
"$@" 2> "$LOG.readonly"; echo $? > "$LOG.readonly.code"
set -e
mount -o remount,rw "$DIR"
"$@" 2> "$LOG.roomy"
cp -a "$DIR/data" "$LOG.data"
"""


def test_a_full_and_a_read_only_disk_are_one_line_each_and_cost_nothing(shared: Shared, tmp_path: Path) -> None:
    disk, log, whole = tmp_path / "disk", tmp_path / "log", tmp_path / "whole"
    disk.mkdir()
    apart = ["unshare", "--user", "--map-root-user", "--mount"]
    if subprocess.run([*apart, "mount", "-t", "tmpfs", "tmpfs", str(disk)], capture_output=True).returncode:
        pytest.skip("this system mounts nothing in a namespace of its own")
    subprocess.run(command(shared.small, whole), check=True, capture_output=True)
    taken = sum(path.stat().st_size for path in whole.rglob("*") if path.is_file())
    given = {"DIR": str(disk), "LOG": str(log), "SMALL": f"{taken // 2048}k"}
    words = [*apart, "sh", "-c", FULL, "sh", *command(shared.small, disk / "data")]
    subprocess.run(words, check=True, env=os.environ | given, capture_output=True, timeout=900)
    for name, reason in (("full", "No space left on device"), ("readonly", "Read-only file system")):
        said = (tmp_path / f"log.{name}").read_text()
        assert (tmp_path / f"log.{name}.code").read_text() == "2\n", said
        (line,) = [line for line in said.splitlines() if line.startswith("error: ")]
        assert reason in line
        assert "Traceback" not in said
    assert hashes(tmp_path / "log.data") == hashes(whole)
