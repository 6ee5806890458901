"""Plant faults in copies of the tree, one at a time, and see whether the tests of their room notice.

``python -m tests.faults.run`` runs all of them and prints each, ``--only TEXT`` those whose room or name holds a text,
``--write`` renews ``benchmarks/results/faults.json``. A fault counts as caught when a test fails with it that passes
without it.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("labels", "scores", "formats", "generation")
RESULT = ROOT / "benchmarks" / "results" / "faults.json"
_COMMAND = "make test-faults"
_LEFT_OUT = (".git", ".venv*", "out", "build", "dist", ".*_cache", "__pycache__")
_FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+\.py(?:::.*?)?)(?: - .*)?$", re.MULTILINE)
_PASSED, _FOUND_SOME = 0, 1
"""What pytest returns when all pass, and when some do not."""


@dataclass(frozen=True)
class Fault:
    """One change to one file."""

    room: str
    name: str
    file: str
    find: str
    """Stands once in the file."""
    replace: str
    tests: tuple[str, ...]
    """Files or folders of the room's tests."""

    def planted(self, text: str) -> str:
        """Return the file's text with the fault.

        Raises:
            ValueError: What it changes stands there never, or more than once.
        """
        count = text.count(self.find)
        if count != 1:
            raise ValueError(f"{self.room}: {self.name}: {self.file} holds {self.find!r} {count} times, not once")
        return text.replace(self.find, self.replace)


@dataclass(frozen=True)
class Outcome:
    """What the tests said of a fault."""

    fault: Fault
    by: str
    """The test that failed, empty where none did."""
    seconds: float

    def row(self) -> dict[str, Any]:
        """Return the row of the result."""
        name = f"{self.fault.room}: {self.fault.name}"
        return {"name": name, "value": int(bool(self.by)), "by": self.by, "seconds": round(self.seconds)}


def read_faults() -> list[Fault]:
    """Return the faults of all rooms."""
    faults = []
    for room in ROOMS:
        rows = yaml.safe_load((Path(__file__).parent / f"{room}.yaml").read_text(encoding="utf-8"))
        faults += [Fault(room, **{**row, "tests": tuple(row["tests"])}) for row in rows]
    return faults


def judged(fault: Fault, tree: Path) -> Outcome:
    """Return what the tests say of a fault; the copy of the tree is as before afterwards."""
    start, path = time.monotonic(), tree / fault.file
    with _planted(fault, path):
        code, failed = _tested(tree, fault.tests)
    if code == _PASSED:
        return Outcome(fault, "", time.monotonic() - start)
    if code != _FOUND_SOME or not failed:
        raise RuntimeError(f"{fault.room}: {fault.name}: pytest returned {code} over {' '.join(fault.tests)}")
    code, _ = _tested(tree, (failed,))
    if code != _PASSED:
        raise RuntimeError(f"{fault.room}: {fault.name}: {failed} fails without the fault, too")
    return Outcome(fault, failed, time.monotonic() - start)


def judge_all(faults: list[Fault], processes: int) -> Iterator[Outcome]:
    """Yield what the tests say of each fault, in their order, as many at a time as there are processes."""
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        trees: SimpleQueue[Path] = SimpleQueue()
        for number in range(processes):
            trees.put(_copy(Path(folder) / str(number)))

        def judge(fault: Fault) -> Outcome:
            tree = trees.get()
            try:
                return judged(fault, tree)
            finally:
                trees.put(tree)

        with ThreadPoolExecutor(processes) as pool:
            yield from pool.map(judge, faults)


def main() -> int:
    """Run the faults and print what became of each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="run the faults whose room or name holds this")
    parser.add_argument("--processes", type=int, default=2, help="how many run at a time")
    parser.add_argument("--write", action="store_true", help=f"write {RESULT.relative_to(ROOT)}")
    options = parser.parse_args()
    outcomes, chosen = [], [item for item in read_faults() if options.only in f"{item.room}: {item.name}"]
    for outcome in judge_all(chosen, options.processes):
        outcomes.append(outcome)
        verdict = f"caught by {outcome.by}" if outcome.by else "MISSED"
        print(f"{outcome.fault.room}: {outcome.fault.name}: {verdict} ({outcome.seconds:.0f} s)", flush=True)
    caught = sum(bool(outcome.by) for outcome in outcomes)
    print(f"{caught} of {len(outcomes)} caught")
    if options.write:
        from benchmarks.speed.result import write_result

        write_result(RESULT, _COMMAND, [{"name": "all", "value": caught}, *(outcome.row() for outcome in outcomes)])
    return 0 if caught == len(outcomes) else 1


def _copy(tree: Path) -> Path:
    """Copy the tree, with compiled files that are told apart by their sources' content, not by time and size."""
    shutil.copytree(ROOT, tree, symlinks=True, ignore=shutil.ignore_patterns(*_LEFT_OUT))
    command = [sys.executable, "-m", "compileall", "-q", "--invalidation-mode", "checked-hash", "warehouse_sim"]
    subprocess.run(command, cwd=tree, check=True)
    return tree


@contextmanager
def _planted(fault: Fault, path: Path) -> Iterator[None]:
    text = path.read_text(encoding="utf-8")
    path.write_text(fault.planted(text), encoding="utf-8")
    try:
        yield
    finally:
        path.write_text(text, encoding="utf-8")


def _tested(tree: Path, tests: tuple[str, ...]) -> tuple[int, str]:
    """Run the fast tests among ``tests``; return what pytest returned and the first one that failed."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow and not ecosystem"]
    env = os.environ | {"PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([*command, *tests], cwd=tree, env=env, capture_output=True, text=True, check=False)
    failed = _FAILED.search(done.stdout)
    return done.returncode, failed[1] if failed else ""


if __name__ == "__main__":
    sys.exit(main())
