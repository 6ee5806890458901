"""How worker processes start."""

import os


def prepare_worker() -> None:
    """Give the process one thread in every library: more would only fight for the same processors."""
    for variable in ("LP_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
