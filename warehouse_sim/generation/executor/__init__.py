"""Scenes are made one after the other in this process, or side by side in several."""

import os
import pickle
import signal
import sys
import time
import traceback
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from multiprocessing import connection, get_context, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import ForkServerContext, SpawnContext
from typing import Any, Self

from warehouse_sim.errors import WorkerError
from warehouse_sim.generation.executor.failures import Failures, Skip, time_limit, too_long
from warehouse_sim.processes import end_at_once_with_parent, few_collections, keep_freed_memory, prepare_worker

Work = Callable[[int], Any]
"""Makes the scene of that index."""
OpenWork = Callable[[], AbstractContextManager[Work]]
"""Opens what a process needs for all its scenes, such as a renderer; can be pickled."""
Made = Generator[tuple[int, Any], None, None]
"""Scene indices with what the work returned."""

_OPENED = "opened"
"""What a worker says first of all."""
_START_S = 120.0
"""What it may take to say that."""
_IMPORTED_ONCE = "warehouse_sim.generation.executor.preload"
"""The module whose imports workers share."""
_AHEAD = 2
"""Scenes a worker that are begun before the first of them is taken, where order counts."""


def make_scenes(
    open_work: OpenWork,
    seed: int,
    scene_indices: Sequence[int],
    workers: int,
    limit_s: float | None = None,
    skip: Skip | None = None,
) -> Made:
    """Yield each scene's index with what the work returned for it, in the order in which they are finished.

    Args:
        open_work: Called once in each process.
        seed: Seed of the dataset, for messages.
        scene_indices: Scenes to make.
        workers: Processes, >= 1; 1 works in this one.
        limit_s: How long a try may take; a worker that takes longer is killed. None = as long as it does.
        skip: Takes scenes that failed twice; None = they end the run.

    Raises:
        WorkerError: A scene ended every worker that made it, or took too long twice; the others are made before this
            is raised. With ``skip``, so many failed that something else is to blame.
        Exception: What the work raised twice; scenes that other workers are making then are finished before.
    """
    if not scene_indices:
        return
    failures = Failures(seed, skip)
    if workers > 1:
        with _Pool(open_work, failures, scene_indices, limit_s) as pool:
            yield from pool.run(min(workers, len(scene_indices)))
    else:
        yield from _make_here(open_work, scene_indices, limit_s, failures)


def make_in_order(
    open_work: OpenWork, seed: int, scene_indices: Iterable[int], workers: int, apart: bool = False
) -> Made:
    """Yield as ``make_scenes``, but in the order of ``scene_indices``, which may have no end.

    Scenes are made as they are taken: at most two a worker are begun and not taken yet. What is not taken to the end
    must be closed, as a generator is; its workers end then. With ``apart`` a single worker is a process of its own,
    too, which works on while this one does something else.

    Raises:
        WorkerError: As ``make_scenes``; scenes after the one that was lost are not yielded.
        Exception: What the work raised.
    """
    failures = Failures(seed)
    if workers == 1 and not apart:
        yield from _make_here(open_work, scene_indices, None, failures)
        return
    with _Pool(open_work, failures, scene_indices, None, _AHEAD * workers) as pool:
        ready: dict[int, Any] = {}
        for made, result in pool.run(workers):
            ready[made] = result
            while pool.order and pool.order[0] in ready:
                index = pool.order.popleft()
                yield index, ready.pop(index)
                pool.begin_idle()


def _make_here(open_work: OpenWork, scene_indices: Iterable[int], limit_s: float | None, failures: Failures) -> Made:
    """Yield scenes as they are made in this process."""
    keep_freed_memory()
    with open_work() as work:
        for index in scene_indices:
            again = True
            while again:
                try:
                    with time_limit(limit_s), few_collections():
                        result = work(index)
                except Exception as problem:
                    again = failures.raised(index, problem)
                else:
                    failures.made()
                    yield index, result
                    break
            if failures.stop:
                break
    failures.raise_them()


class _Worker:
    """A process that makes one scene at a time; a dead one is found when its answer is waited for.

    Args:
        open_work: An ``OpenWork``, pickled.
    """

    def __init__(self, open_work: bytes) -> None:
        context = _start_method()
        self.pipe, theirs = context.Pipe()
        self.scene_index: int | None = None
        """The scene that it is making."""
        self.since = 0.0
        """When that was begun, on the monotonic clock; of the first scene, when it must be."""
        self.is_open = False
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        resource_tracker.ensure_running()  # It lets interrupts through when it starts.
        with _interrupts_later():
            self._process.start()
        theirs.close()  # The worker alone holds it now, so that its death ends the pipe.
        with suppress(OSError):
            self.pipe.send(dict(os.environ))  # What started the process may have had another.
            self.pipe.send_bytes(open_work)

    def begin(self, scene_index: int) -> None:
        """Require a scene."""
        self.scene_index, self.since = scene_index, time.monotonic() + (0.0 if self.is_open else _START_S)
        with suppress(OSError):
            self.pipe.send(scene_index)

    def end(self) -> int:
        """Let the process end, at once if it is making a scene, and return its exit code."""
        self.pipe.close()
        if self.scene_index is not None:
            self._process.kill()
        self._process.join()
        return self._process.exitcode or 0


class _Pool:
    """Workers, and the scenes that wait for one."""

    def __init__(
        self,
        open_work: OpenWork,
        failures: Failures,
        scene_indices: Iterable[int],
        limit_s: float | None,
        ahead: int | None = None,
    ) -> None:
        self._open_work, self._fresh = pickle.dumps(open_work), iter(scene_indices)
        self._failures, self._limit_s, self._ahead = failures, limit_s, ahead
        self._again: list[int] = []
        """Scenes that failed once."""
        self.order: deque[int] = deque()
        """With ``ahead``, scenes that are begun; who takes them removes them, and no more than that are there."""
        self._workers: list[_Worker] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self._workers:
            worker.end()

    def run(self, workers: int) -> Made:
        """Yield scenes as they are finished."""
        for _ in range(workers):
            self._begin_next(self._start_worker())
        while busy := {worker.pipe: worker for worker in self._workers if worker.scene_index is not None}:
            for pipe in connection.wait(list(busy), self._until_limit()):
                yield from self._take_answer(busy[pipe])  # type: ignore[index]  # wait returns what it was given
            self._end_late()
        self._failures.raise_them()

    def _take_answer(self, worker: _Worker) -> Made:
        """Yield the scene that the worker has finished, if it has, and see that work goes on."""
        index = worker.scene_index
        assert index is not None
        answer = None
        with suppress(EOFError, OSError):
            answer = worker.pipe.recv()
        if answer is None:
            self._replace(worker)
            return
        if answer == _OPENED:
            worker.is_open, worker.since = True, time.monotonic()
            return
        result, problem = answer
        worker.scene_index = None
        if problem is None:
            self._failures.made()
        elif self._failures.raised(index, problem):
            self._again.append(index)
        self._begin_next(worker)
        if problem is None:
            yield index, result

    def _until_limit(self) -> float | None:
        """Return the seconds until the first worker has taken too long; None where there is no limit."""
        if self._limit_s is None:
            return None
        first = min(worker.since for worker in self._workers if worker.scene_index is not None)
        return max(first + self._limit_s - time.monotonic(), 0.0)

    def _end_late(self) -> None:
        """Kill workers that have taken too long."""
        if self._limit_s is None:
            return
        now = time.monotonic()
        for worker in list(self._workers):
            late = worker.scene_index is not None and now - worker.since >= self._limit_s
            if late and not worker.pipe.poll():  # what it says at the last moment counts
                self._replace(worker, too_long(self._limit_s))

    def _start_worker(self) -> _Worker:
        self._workers.append(_Worker(self._open_work))
        return self._workers[-1]

    def begin_idle(self) -> None:
        """Let workers that had to wait for scenes to be taken go on."""
        for worker in self._workers:
            if worker.scene_index is None:
                self._begin_next(worker)

    def _begin_next(self, worker: _Worker) -> None:
        index = self._next()
        if index is not None:
            worker.begin(index)

    def _next(self) -> int | None:
        """Take the scene that is to be begun now, if any is."""
        if self._failures.stop:
            return None
        if self._again:
            return self._again.pop()
        if self._ahead is not None and len(self.order) >= self._ahead:
            return None
        index = next(self._fresh, None)
        if self._ahead is not None and index is not None:
            self.order.append(index)
        return index

    def _replace(self, dead: _Worker, cause: str = "") -> None:
        """Take note of what ended a worker, and put another in its place."""
        index = dead.scene_index
        assert index is not None
        self._workers.remove(dead)
        exit_code = dead.end()
        if exit_code == 1 and not dead.is_open and not cause:
            raise WorkerError(
                "a worker ended before it began; a script that makes scenes with workers must do so under "
                'if __name__ == "__main__":'
            )
        if self._failures.died(index, cause or _cause(exit_code)):
            self._again.append(index)
        following = self._next()
        if following is not None:
            self._start_worker().begin(following)


def _start_method() -> ForkServerContext | SpawnContext:
    """Return how processes are started that make scenes: forked, on Linux, from one that has imported what they need.

    They are not forked from this process, as an OpenGL context does not survive that; elsewhere nothing is forked, as
    system libraries do not bear it.
    """
    if sys.platform != "linux":
        return get_context("spawn")
    context = get_context("forkserver")
    context.set_forkserver_preload([_IMPORTED_ONCE])
    return context


@contextmanager
def _interrupts_later() -> Iterator[None]:
    """Hold Ctrl-C back while the block runs; a process that it starts never sees one, nor ends in a traceback by it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _cause(exit_code: int) -> str:
    if exit_code == -signal.SIGKILL:
        return "SIGKILL, which the system sends when memory runs out"
    return signal.Signals(-exit_code).name if exit_code < 0 else f"itself with exit code {exit_code}"


def _serve(pipe: Connection) -> None:
    """Make scenes until nobody requires one."""
    end_at_once_with_parent()  # Seconds later it might still write, where another run has begun to.
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # The terminal sends it to all; the first process decides.
    with ExitStack() as opened, suppress(EOFError):
        environment = pipe.recv()
        os.environ.clear()
        os.environ.update(environment)
        prepare_worker()  # Before anything is imported that starts threads.
        open_work, work = pipe.recv_bytes(), None
        while True:
            index = pipe.recv()
            try:
                if work is None:
                    work = opened.enter_context(pickle.loads(open_work)())
                    pipe.send(_OPENED)
                with few_collections():
                    result = work(index)
                pipe.send((result, None))
            except Exception as problem:
                pipe.send((None, _picklable(problem)))


def _picklable(problem: Exception) -> Exception:
    """Return the error with where it arose as a note, as far as it can be pickled; its text otherwise."""
    problem.add_note("".join(traceback.format_exception(problem)))
    try:
        return pickle.loads(pickle.dumps(problem))
    except Exception:
        return RuntimeError("".join(traceback.format_exception(problem)))
