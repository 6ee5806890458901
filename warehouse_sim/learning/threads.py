"""How many processor threads a network uses: for a small one, handing work around costs more than the work."""

from collections.abc import Iterator
from contextlib import contextmanager

import torch

SMALL = 3_000_000
"""Networks of fewer weights run on one thread."""


@contextmanager
def cpu_threads(wanted: int | None) -> Iterator[None]:
    """Use so many CPU threads in this process during the block; None leaves torch its own number."""
    before = torch.get_num_threads()
    if wanted:
        torch.set_num_threads(wanted)
    try:
        yield
    finally:
        torch.set_num_threads(before)
