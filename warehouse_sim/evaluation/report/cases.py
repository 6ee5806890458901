"""Which ground truths to show: the best, the middle, the worst and the missed."""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.evaluation.error_table import ErrorTable


@dataclass(frozen=True)
class CaseGroup:
    """Rows of an error table that are shown together."""

    title: str
    rows: tuple[int, ...]


def choose_cases(table: ErrorTable, count: int) -> list[CaseGroup]:
    """Choose up to ``count`` rows a group by ADD, no row twice; a group without rows is left out.

    The middle is the middle of what was found; misses, which have no estimate to draw, are shown the most visible
    first, since those are the least excusable.
    """
    found = np.flatnonzero(table.found)
    ranked = found[np.argsort(table.add[found], kind="stable")].tolist()
    size = min(count, len(ranked) // 3 or len(ranked))
    best, worst = ranked[:size], ranked[::-1][:size]
    start = max(0, (len(ranked) - size) // 2)
    middle = [row for row in ranked[start : start + size] if row not in best and row not in worst]
    missed = np.flatnonzero(~table.found)
    most_visible = missed[np.argsort(-table.visible_fraction[missed], kind="stable")][:count].tolist()
    groups = [
        CaseGroup("Best", tuple(best)),
        CaseGroup("Median", tuple(middle)),
        CaseGroup("Worst", tuple(row for row in worst if row not in best)),
        CaseGroup("Missed", tuple(most_visible)),
    ]
    return [group for group in groups if group.rows]
