"""How processes that make scenes start."""

import ctypes
import os

from warehouse_sim.processes import end_with_parent

# malloc.h of the GNU C library. No larger threshold of the first kind is accepted.
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
_LARGEST_MMAP_THRESHOLD = 32 << 20
_KEPT_BYTES = 128 << 20


def prepare_worker() -> None:
    """Let the process end with its parent, and give it one thread in every library: more would fight for processors."""
    end_with_parent()
    for variable in ("LP_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    keep_freed_memory()


def keep_freed_memory() -> None:
    """Let the process keep the memory of freed arrays for the next ones, where the C library can do so.

    Images and sweeps are made of arrays of some hundred kilobytes. By default the C library gives each of them back
    when it is freed, and the system fills the next one's pages with zeros again: a tenth of an observation's time.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if os.name == "posix" else None
    if mallopt is not None:
        mallopt(_MMAP_THRESHOLD, _LARGEST_MMAP_THRESHOLD)
        mallopt(_TRIM_THRESHOLD, _KEPT_BYTES)
