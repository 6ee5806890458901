"""Processes that this package starts end with the one that started them, however that one ends."""

import os
import threading
from multiprocessing import connection, parent_process


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
