"""Try cases in worker processes, one after the other in each; what dies or never ends is a finding, and is replaced."""

import ctypes
import faulthandler
import io
import multiprocessing
import os
import queue
import resource
import shutil
import signal
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from tests.hostile.case import Case, Outcome, Step, name_of
from tests.hostile.judge import Verdict, judge

_SECONDS = 60.0
"""Processor time of a case."""
_WALL_SECONDS = 600.0
"""Others may be at work; what sleeps that long never ends."""
_MEMORY = 8 * 2**30
# Contexts of OpenGL that come and go are what drivers leak; a worker is not to die of the cases before.
_CASES_A_WORKER = 250
_DIE_WITH_PARENT = 1
"""PR_SET_PDEATHSIG of Linux's prctl."""


def try_cases(
    cases: Sequence[Case],
    workers: int,
    scratch: Path,
    done: Callable[[Case, Verdict], None] = lambda case, verdict: None,
) -> list[Verdict]:
    """Try cases on several workers side by side and return the verdicts in their order."""
    waiting: queue.SimpleQueue[int] = queue.SimpleQueue()
    for index in range(len(cases)):
        waiting.put(index)
    verdicts: dict[int, Verdict] = {}
    failures: list[BaseException] = []

    def serve(place: Path) -> None:
        worker = Worker(place)
        try:
            while not failures:
                index = waiting.get_nowait()
                verdicts[index] = worker.try_case(cases[index])
                done(cases[index], verdicts[index])
        except queue.Empty:
            pass
        except BaseException as problem:
            failures.append(problem)
        finally:
            worker.close()

    threads = [threading.Thread(target=serve, args=(scratch / f"worker-{number}",)) for number in range(workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if failures:
        raise failures[0]
    return [verdicts[index] for index in range(len(cases))]


class Worker:
    """A process that tries cases; a new one after enough of them, or after one that it did not survive.

    Args:
        scratch: Folder for the cases and the streams.
    """

    def __init__(self, scratch: Path) -> None:
        self._scratch, self._tried = scratch, 0
        self._process: Any = None

    def try_case(self, case: Case) -> Verdict:
        """Write the case into a new folder, run its steps while they succeed, and judge."""
        if self._process is None or self._tried % _CASES_A_WORKER == 0:
            self._start()
        self._tried += 1
        try:
            self._pipe.send((case, self._tried))
            answer = self._pipe.recv() if self._pipe.poll(_WALL_SECONDS) else f"slept for {_WALL_SECONDS:g} s"
        except (EOFError, ConnectionResetError):
            self._process.join()
            number = -self._process.exitcode
            death = signal.Signals(number).name if number > 0 else f"exit code {-number} from within"
            answer = f"was busy for {_SECONDS:g} s" if death == "SIGPROF" else f"died: {death}"
        if isinstance(answer, BaseException):
            raise RuntimeError(f"the harness itself failed on {case.id}") from answer
        if isinstance(answer, Verdict):
            return answer
        last = (self._scratch / "err.txt").read_text(encoding="utf-8", errors="replace").strip()[-1500:]
        self.close()
        return Verdict("raw", f"{name_of(case.steps[0])} {answer}\n{last}")

    def close(self) -> None:
        """End the process and all that it has started."""
        if self._process is not None:
            try:
                os.killpg(self._process.pid, signal.SIGKILL)
            except ProcessLookupError:
                self._process.kill()
            self._process.join()
            self._process = None

    def _start(self) -> None:
        self.close()
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, self._scratch))
        self._process.start()
        theirs.close()


def _serve(pipe: Connection, scratch: Path) -> None:
    """Try each case that comes, until the parent is gone."""
    os.setsid()
    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY, _MEMORY))
    warnings.simplefilter("always")
    scratch.mkdir(parents=True, exist_ok=True)
    # Both streams, also what C libraries write, into files, and each line at once: a crash loses none.
    paths = scratch / "out.txt", scratch / "err.txt"
    for number, path in enumerate(paths, start=1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND), number)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.stdout, sys.stderr = (
        io.TextIOWrapper(io.FileIO(number, "w", closefd=False), encoding="utf-8", errors="replace", write_through=True)
        for number in (1, 2)
    )
    faulthandler.enable(2)
    faulthandler.register(signal.SIGPROF, 2, all_threads=False, chain=True)
    while True:
        try:
            case, number = pipe.recv()
        except (EOFError, ConnectionResetError):
            return
        pipe.send(_attempt(case, scratch / f"case-{os.getpid()}-{number}", paths))


def _attempt(case: Case, folder: Path, paths: tuple[Path, Path]) -> Verdict | BaseException:
    folder.mkdir()
    start = time.process_time()
    try:
        if case.write is not None:
            case.write(folder)
        os.chdir(folder)
        signal.setitimer(signal.ITIMER_PROF, _SECONDS)
        outcomes: list[Outcome] = []
        while len(outcomes) < len(case.steps) and (not outcomes or outcomes[-1].code == 0):
            outcomes.append(_run(case.steps[len(outcomes)], paths))
        return replace(judge(case, outcomes, folder), seconds=time.process_time() - start)
    except BaseException as problem:
        problem.add_note(traceback.format_exc())
        return problem
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        os.chdir(folder.parent)
        shutil.rmtree(folder)


def _run(step: Step, paths: tuple[Path, Path]) -> Outcome:
    """Run a step as a terminal would see it; of a call, print the error as the command line does."""
    from warehouse_sim.cli.main import main
    from warehouse_sim.errors import WarehouseSimError

    for number in (1, 2):
        os.ftruncate(number, 0)
    value, code = None, 1
    try:
        if isinstance(step, tuple):
            code = main(list(step))
        else:
            value, code = step(), 0
    except WarehouseSimError as problem:
        sys.stderr.write(f"error: {problem}\n")
        code = 2
    except SystemExit as leaving:
        traceback.print_exc()
        code = leaving.code if isinstance(leaving.code, int) else 1
    except BaseException:
        traceback.print_exc()
    out, err = (path.read_text(encoding="utf-8", errors="replace") for path in paths)
    return Outcome(name_of(step), code, out, err, value)
