"""Processes that this package starts end with the one that started them, however that one ends."""

import ctypes
import os
import signal
import sys
import threading
from multiprocessing import connection, parent_process

_PR_SET_PDEATHSIG = 1
"""prctl(2)."""


def end_at_once_with_parent() -> None:
    """Let the system kill this process when its parent ends, however busy it is; elsewhere than on Linux do nothing.

    The system takes the parent's thread that started this process for the parent: that must be its main thread.
    """
    parent = parent_process()
    if sys.platform != "linux" or parent is None:
        return
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent.pid:  # It ended before the check.
        os._exit(1)


def end_with_parent() -> None:
    """Let this process end as soon as the one that started it through multiprocessing is gone, even killed.

    A thread waits for that; a process at work would notice by itself only when it next asks for something to do.
    """
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_wait_and_end, args=(parent.sentinel,), name="end with parent", daemon=True).start()


def _wait_and_end(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)  # Whatever is at work, nobody waits for it.
