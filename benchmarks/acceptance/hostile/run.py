"""Try cases on several workers side by side."""

import queue
import shutil
import tempfile
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.acceptance.hostile.case import Case
from benchmarks.acceptance.hostile.judge import Verdict, judge
from benchmarks.acceptance.hostile.watch import Limits, Outcome, Watched

COMMAND = "warehouse_sim.cli.main:main"


@dataclass(frozen=True)
class Result:
    """A case with what it did and the verdict."""

    case: Case
    outcomes: tuple[Outcome, ...]
    verdict: Verdict

    @property
    def seconds(self) -> float:
        """Time of all its command lines (s)."""
        return sum(outcome.seconds for outcome in self.outcomes)


def try_cases(
    cases: Sequence[Case],
    workers: int,
    limits: Limits,
    done: Callable[[Result], None] = lambda result: None,
    command: str = COMMAND,
) -> list[Result]:
    """Try ``cases`` and return the results in their order.

    Args:
        cases: What to try.
        workers: Worker processes side by side.
        limits: When a command line is given up.
        done: Told after each case, from any thread, one at a time.
        command: ``module:function`` that runs a command line.
    """
    waiting: queue.SimpleQueue[int] = queue.SimpleQueue()
    for index in range(len(cases)):
        waiting.put(index)
    results: dict[int, Result] = {}
    failures: list[BaseException] = []
    lock = threading.Lock()

    def serve() -> None:
        with (
            tempfile.TemporaryDirectory(prefix="hostile-") as scratch,
            Watched(command, limits, Path(scratch)) as watched,
        ):
            while not failures:
                try:
                    index = waiting.get_nowait()
                except queue.Empty:
                    return
                try:
                    result = try_case(cases[index], watched, Path(scratch) / f"case-{index}")
                    if result.verdict.is_fault:
                        # Once more as a user would: in a process that has done nothing before.
                        watched.renew()
                        result = try_case(cases[index], watched, Path(scratch) / f"case-{index}-again")
                except BaseException as problem:
                    failures.append(problem)
                    raise
                with lock:
                    results[index] = result
                    done(result)

    threads = [threading.Thread(target=serve) for _ in range(workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if failures:
        raise RuntimeError("the harness itself failed") from failures[0]
    return [results[index] for index in range(len(cases))]


def try_case(case: Case, watched: Watched, folder: Path) -> Result:
    """Write the case into ``folder``, run its command lines while they succeed, and judge."""
    folder.mkdir()
    try:
        case.write(folder)
        outcomes: list[Outcome] = []
        for step in case.steps:
            outcomes.append(watched.run(tuple(word.replace("{folder}", str(folder)) for word in step), folder))
            if outcomes[-1].code != 0:
                break
        return Result(case, tuple(outcomes), judge(case, outcomes, folder))
    finally:
        shutil.rmtree(folder)
