"""`make speed` runs through in its quick form, and its clock counts what it says."""

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.speed import stages
from benchmarks.speed.__main__ import main
from benchmarks.speed.cost import Cost, StageClock, median
from warehouse_sim.sensors.lidar import LIDAR_PRESETS
from warehouse_sim.sensors.rgbd.depth import MODELS

ROOT = Path(__file__).resolve().parents[2]
ROWS = {
    "rgbd_ids_vs_pyrender",
    "rgbd_ids_vs_mujoco",
    "full_observation",
    "training_observation",
    "encoding",
    "formats",
    "memory",
    "scaling",
    "amodal masks",
    "lidar",
    "rgbd_models",
    "paired_variants",
    "inference",
    "latency",
    "training",
    "streaming",
    "feeding",
    "scoring",
}


class Work:
    """Takes a second of its own clock and three of what it calls."""

    def __init__(self) -> None:
        self.now = 0.0

    def outer(self) -> str:
        self.now += 1.0
        return self.inner()

    def inner(self) -> str:
        self.now += 3.0
        return "done"


def test_a_nested_stage_is_taken_out_of_the_one_around_it() -> None:
    work = Work()
    clock = StageClock(lambda: work.now)
    with clock.watching([(work, "outer", "outside"), (work, "inner", "inside")]), clock.stage("all"):
        work.now += 0.5
        assert work.outer() == "done"
        assert work.inner() == "done"
    assert clock.seconds == {"inside": 6.0, "outside": 1.0, "all": 0.5}
    assert vars(work) == {"now": 7.5}  # nothing of the watching is left


def test_a_watched_class_gets_its_function_back_after_an_error() -> None:
    original = Work.inner
    clock = StageClock(time.process_time)
    with pytest.raises(TypeError, match="unexpected"), clock.watching([(Work, "inner", "inside")]):
        Work().inner(unexpected=1)
    assert Work.inner is original
    assert set(clock.seconds) == {"inside"}


def test_medians_are_taken_of_both_times_apart() -> None:
    assert median([Cost(1.0, 9.0), Cost(2.0, 7.0), Cost(30.0, 8.0)]) == Cost(2.0, 8.0)


@pytest.mark.gl
@pytest.mark.slow
def test_a_quick_run_measures_every_row(tmp_path: Path) -> None:
    out = tmp_path / "speed.json"
    command = [sys.executable, "-m", "benchmarks.speed", "--quick", "--recipe", "smoke", "--out", str(out)]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    rows = {row["name"]: row for row in json.loads(out.read_text())["rows"]}
    assert set(rows) == ROWS
    for name in ("rgbd_ids_vs_pyrender", "rgbd_ids_vs_mujoco"):
        assert rows[name]["ids_agree"] > 0.99
        assert rows[name]["depth_agrees"] > 0.99
    assert all(method["network_cpu_s"] > 0 for method in rows["inference"]["methods"].values())
    stages = rows["latency"]["stages_cpu_s"]
    assert {"crops", "network", "hypotheses", "coarse ICP", "ICP", "verification", "uncertainty"} <= set(stages)
    assert all(seconds >= 0 for seconds in stages.values())
    assert rows["latency"]["icp"]["cpu_s"] > 0
    assert all(0.0 <= method["waited_fraction"] < 1.0 for method in rows["feeding"]["methods"].values())
    assert sum(rows["full_observation"]["fractions"].values()) == pytest.approx(1.0, abs=0.01)
    assert rows["lidar"]["two_processes"]["rays_per_wall_s"] > 0
    assert set(rows["lidar"]["presets_cpu_s"]) == set(LIDAR_PRESETS)
    assert {f"depth: {name}" for name in MODELS} <= set(rows["rgbd_models"]["models_cpu_s"])
    assert [size["instances"] for size in rows["scaling"]["table"]] == [10, 100]


def test_an_unknown_row_is_named() -> None:
    with pytest.raises(SystemExit, match="no such rows: encodin; known: rgbd_ids_vs_pyrender"):
        main(only=("encodin",))


def test_every_function_that_stages_watch_is_where_they_look():
    missing = [f"{owner.__name__}.{name}" for owner, name, _ in stages._FUNCTIONS if not hasattr(owner, name)]
    assert missing == []
