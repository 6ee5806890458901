"""How many processes a command starts."""

import os

from warehouse_sim.errors import InputError


def processes(workers: int | None) -> int:
    """Return the number given by ``--workers``, or that of the processors where there is none.

    Raises:
        InputError: It is below 1.
    """
    if workers is not None and workers < 1:
        raise InputError(f"--workers must be at least 1, found {workers}; leave it out for one per processor")
    return workers or os.cpu_count() or 1
