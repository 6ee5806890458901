import ctypes
import os
import subprocess
import sys
from pathlib import Path

import pytest

FAULTS = """
import resource, numpy as np
{prepare}
def work():
    for _ in range(4):
        arrays = [np.ones(500_000, np.float32) for _ in range(8)]
        del arrays
work()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
work()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def faults(prepare: str) -> int:
    """Return how many pages the system handed out again while arrays were made and freed again."""
    run = subprocess.run([sys.executable, "-c", FAULTS.format(prepare=prepare)], capture_output=True, check=True)
    return int(run.stdout)


@pytest.mark.skipif(
    os.name != "posix" or not hasattr(ctypes.CDLL(None), "mallopt"), reason="no C library that can be told"
)
def test_a_worker_keeps_the_memory_of_freed_arrays() -> None:
    from_start = "from warehouse_sim.processes import prepare_worker; prepare_worker()"
    assert faults(from_start) < 100
    assert faults("") > 1000


def test_a_worker_has_one_thread_in_every_library_unless_told_otherwise() -> None:
    code = (
        "import os; from warehouse_sim.processes import prepare_worker; prepare_worker();"
        "print(os.environ['LP_NUM_THREADS'], os.environ['OMP_NUM_THREADS'])"
    )
    environment = {**os.environ, "LP_NUM_THREADS": "3"}
    environment.pop("OMP_NUM_THREADS", None)
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, env=environment)
    assert run.stdout.split() == [b"3", b"1"]


def test_a_script_without_a_guard_is_named_once(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text('import warehouse_sim as ws\nprint(next(iter(ws.stream("smoke", scenes=1))))\n')
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert run.stderr.count("Traceback") == 1
    assert 'under if __name__ == "__main__":' in run.stderr.splitlines()[-1]
