"""A limit to the time that a scene may take in this process."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from warehouse_sim.errors import WorkerError


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Raise an error in the block when it takes longer.

    Only Python is interrupted, not a call into a library that never returns, and only in the main thread of a system
    with interval timers whose alarm nobody else uses; elsewhere there is no limit. Workers of their own are killed.

    Args:
        seconds: How long it may take; None = as long as it does.

    Raises:
        WorkerError: It took longer.
    """
    if seconds is None or not _is_free():
        yield
        return

    def expire(_: int, __: FrameType | None) -> None:
        raise WorkerError(too_long(seconds))

    signal.signal(signal.SIGALRM, expire)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)


def too_long(seconds: float) -> str:
    """Say that a limit was reached."""
    return f"its limit of {seconds:g} s for a scene (--scene-limit)"


def _is_free() -> bool:
    in_main = threading.current_thread() is threading.main_thread()
    return in_main and hasattr(signal, "setitimer") and signal.getsignal(signal.SIGALRM) == signal.SIG_DFL
