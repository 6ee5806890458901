"""Processes that make scenes: they end with the one that started them, and what Python and libraries do for each."""

import ctypes
import gc
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import connection, current_process, parent_process

_PR_SET_PDEATHSIG = 1
"""prctl(2)."""


def end_at_once_with_parent() -> None:
    """Let the system kill this process when its parent ends, however busy it is; elsewhere than on Linux do nothing.

    Where one process forks others for the parent, it must end with the parent, as that of multiprocessing does.
    """
    parent = parent_process()
    if sys.platform != "linux" or parent is None:
        return
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if connection.wait([parent.sentinel], 0.0):  # It ended before.
        os._exit(1)


def end_where_a_script_runs_again() -> None:
    """End this process where multiprocessing runs the user's script again in it to begin a worker.

    There, a script without ``if __name__ == "__main__":`` would start workers of its own.
    """
    if getattr(current_process(), "_inheriting", False):
        raise SystemExit(1)


def end_with_parent() -> None:
    """Let this process end as soon as the one that started it through multiprocessing is gone, even killed.

    A thread waits for that; a process at work would notice by itself only when it next requires something to do.
    """
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_wait_and_end, args=(parent.sentinel,), name="end with parent", daemon=True).start()


def _wait_and_end(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)  # Whatever is at work, nobody waits for it.


# malloc.h of the GNU C library. No larger threshold of the first kind is accepted.
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
_LARGEST_MMAP_THRESHOLD = 32 << 20
_KEPT_BYTES = 128 << 20


def prepare_worker() -> None:
    """Let the process end with its parent, and give it one thread in every library: more would fight for processors."""
    end_with_parent()
    one_thread_each()
    keep_freed_memory()


def one_thread_each() -> None:
    """Give this process one thread in every library that is imported from now on."""
    for variable in ("LP_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(variable, "1")


def keep_freed_memory() -> None:
    """Let the process keep the memory of freed arrays for the next ones, where the C library can do so.

    Images and sweeps are made of arrays of some hundred kilobytes. By default the C library gives each of them back
    when it is freed, and the system fills the next one's pages with zeros again: a tenth of an observation's time.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if os.name == "posix" else None
    if mallopt is not None:
        mallopt(_MMAP_THRESHOLD, _LARGEST_MMAP_THRESHOLD)
        mallopt(_TRIM_THRESHOLD, _KEPT_BYTES)


_OBJECTS_BETWEEN = 50_000
"""New objects, less those that went, after which Python looks for cycles; 700 by default."""


@contextmanager
def few_collections() -> Iterator[None]:
    """Let Python look for cycles of objects less often while the block runs.

    A scene is many objects that live as long as it does, and hardly any of them are in a cycle.
    """
    before = gc.get_threshold()
    gc.set_threshold(_OBJECTS_BETWEEN, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)
