"""Work through many rows block by block, on all cores: numpy lets other threads run while it computes."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache

from threadpoolctl import ThreadpoolController  # type: ignore[import-untyped]


def in_blocks(rows: int, at_once: int, work: Callable[[slice], None]) -> None:
    """Call ``work`` with each block of rows; the blocks, not the cores, decide what is computed together.

    Args:
        rows: How many there are.
        at_once: Rows of a block, few enough for the processor's cache; at least one is taken.
        work: Fills in the rows of a block, and nothing else.
    """
    step = max(1, at_once)
    blocks = [slice(first, min(first + step, rows)) for first in range(0, rows, step)]
    if len(blocks) < 2:
        for block in blocks:
            work(block)
        return
    # The threads of BLAS would fight with these for the same cores: a product of matrices takes three times as long.
    with _libraries().limit(limits=1, user_api="blas"), ThreadPoolExecutor(os.cpu_count()) as pool:
        for _ in pool.map(work, blocks):
            pass


@cache
def _libraries() -> ThreadpoolController:
    return ThreadpoolController()
