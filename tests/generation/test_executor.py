"""Processes that make scenes: killed, failing, orphaned."""

import gc
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from pathlib import Path

import pytest

from tests.processes import left_after_kill, scene_workers
from tests.shared import Shared
from warehouse_sim.errors import SettleError, UnknownNameError, WorkerError
from warehouse_sim.generation.executor import Work, make_scenes


def made(work: Work, scenes: range, workers: int) -> dict[int, object]:
    return dict(make_scenes(partial(nullcontext, work), 5, scenes, workers))


def square(index: int) -> int:
    return index**2


def killed(folder: Path, fatal: dict[int, int], index: int) -> int:
    """Leave a mark a try; in a scene of ``fatal``, as often as that says, kill the process that makes it."""
    tries = len(list(folder.glob(f"{index}.*")))
    (folder / f"{index}.{tries}").touch()
    if tries < fatal.get(index, 0):
        os.kill(os.getpid(), signal.SIGKILL)
    return index**2


@pytest.mark.parametrize("workers", [1, 3])
def test_every_scene_is_made_once(workers: int) -> None:
    assert made(square, range(7), workers) == {index: index**2 for index in range(7)}
    assert made(square, range(0), workers) == {}


def objects_between(index: int) -> int:
    return gc.get_threshold()[0]


@pytest.mark.parametrize("workers", [1, 2])
def test_cycles_are_looked_for_less_often_while_a_scene_is_made(workers: int) -> None:
    before = gc.get_threshold()
    gc.set_threshold(700)
    try:
        found = made(objects_between, range(2), workers)
        assert gc.get_threshold()[0] == 700
    finally:
        gc.set_threshold(*before)
    assert all(isinstance(value, int) and value > 10 * 700 for value in found.values())


def test_a_worker_that_is_killed_costs_nothing(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert made(partial(killed, tmp_path, {2: 1, 5: 1}), range(6), 2) == {index: index**2 for index in range(6)}
    tries = sorted(path.name for path in tmp_path.iterdir())
    assert tries == ["0.0", "1.0", "2.0", "2.1", "3.0", "4.0", "5.0", "5.1"]
    assert "scene 2 of seed 5 was ended by SIGKILL" in caplog.text


def test_a_scene_that_always_kills_is_named_after_all_others_are_made(tmp_path: Path) -> None:
    found = []
    scenes = make_scenes(partial(nullcontext, partial(killed, tmp_path, {1: 9})), 5, range(6), 2)
    with pytest.raises(WorkerError, match=r"scene 1 of seed 5 was ended by SIGKILL.*2 times.*--workers 1") as problem:
        found.extend(index for index, _ in scenes)
    assert sorted(found) == [0, 2, 3, 4, 5]
    assert len(list(tmp_path.glob("1.*"))) == 2
    assert "\n" not in str(problem.value)


def test_a_machine_that_kills_every_worker_is_not_requested_again_and_again(tmp_path: Path) -> None:
    with pytest.raises(WorkerError, match=r"(scene \d+ of seed 5 was ended by SIGKILL.*){3}"):
        made(partial(killed, tmp_path, dict.fromkeys(range(50), 9)), range(50), 2)
    assert len(list(tmp_path.iterdir())) < 10


def interrupts_held(index: int) -> bool:
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())


def test_workers_never_see_an_interrupt_and_their_parent_still_does() -> None:
    assert made(interrupts_held, range(2), 2) == {0: True, 1: True}
    assert not interrupts_held(0)


def greeting(index: int) -> str | None:
    return os.environ.get("WAREHOUSE_SIM_GREETING")


def test_workers_have_the_environment_of_the_moment(monkeypatch: pytest.MonkeyPatch) -> None:
    for word in ("hello", "goodbye"):
        monkeypatch.setenv("WAREHOUSE_SIM_GREETING", word)
        assert made(greeting, range(2), 2) == {0: word, 1: word}
    monkeypatch.delenv("WAREHOUSE_SIM_GREETING")
    assert made(greeting, range(2), 2) == {0: None, 1: None}


def modules_at_start(index: int) -> bool:
    return "warehouse_sim.generation.generate" in sys.modules


@pytest.mark.skipif(sys.platform != "linux", reason="workers are forked on Linux alone")
def test_workers_share_what_they_import() -> None:
    assert made(modules_at_start, range(2), 2) == {0: True, 1: True}


def reject(index: int) -> int:
    if index == 1:
        raise UnknownNameError("pallet", "epal9", ["epal1"])
    if index == 0:
        time.sleep(1.0)
    return index


class UnreadableError(Exception):
    """Cannot be pickled and read again."""

    def __init__(self, one: object, two: object) -> None:
        super().__init__(f"{one} and {two}")


def reject_unreadably(index: int) -> None:
    raise UnreadableError("this", "that")


def test_an_error_of_the_work_arrives_after_the_scenes_at_work(tmp_path: Path) -> None:
    found = []
    with pytest.raises(UnknownNameError, match=r"unknown pallet 'epal9' .*known: epal1"):
        found.extend(index for index, _ in make_scenes(partial(nullcontext, reject), 5, range(60), 2))
    assert 0 in found
    assert len(found) < 60


def test_an_error_that_cannot_travel_arrives_as_its_text() -> None:
    with pytest.raises(RuntimeError, match="this and that"):
        made(reject_unreadably, range(2), 2)


@contextmanager
def reject_to_open() -> Iterator[Work]:
    raise SettleError("no graphics here")
    yield square


def test_what_cannot_be_opened_is_told() -> None:
    with pytest.raises(SettleError, match="no graphics here"):
        list(make_scenes(reject_to_open, 5, range(4), 2))


def test_workers_end_when_their_caller_turns_away() -> None:
    scenes = make_scenes(partial(nullcontext, slow), 5, range(1, 60), 2)
    next(scenes)
    assert len(scene_workers(os.getpid())) == 2
    scenes.close()
    assert scene_workers(os.getpid()) == []


def slow(index: int) -> int:
    """Keep the processor busy, all the while holding on to Python."""
    end = time.monotonic() + (0.1 if index == 1 else 600.0)
    while time.monotonic() < end:
        sum(range(1000))
    return index


ORPHANS = """
from contextlib import nullcontext
from functools import partial
from tests.generation.test_executor import slow
from warehouse_sim.generation.executor import make_scenes
if __name__ == "__main__":
    for index, _ in make_scenes(partial(nullcontext, slow), 0, range(1, 9), 2):
        print(index, flush=True)
"""


def test_workers_end_with_a_parent_that_is_killed(tmp_path: Path) -> None:
    script = tmp_path / "orphans.py"
    script.write_text(ORPHANS)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    process = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, env=environment)
    assert process.stdout is not None
    assert process.stdout.readline() == b"1\n"
    assert left_after_kill(process, 5.0) == set()


@pytest.mark.gl
def test_generate_leaves_no_process_behind_when_it_is_killed(shared: Shared, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "warehouse_sim", "generate", str(shared.small), "--out", str(tmp_path / "data")]
    process = subprocess.Popen([*command, "--scenes", "500", "--workers", "2"], stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    record = tmp_path / "data" / "scenes" / "000000.json"
    deadline = time.monotonic() + 60.0
    while not record.exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert record.exists()
    assert left_after_kill(process, 5.0) == set()
    assert "Traceback" not in process.stderr.read()
