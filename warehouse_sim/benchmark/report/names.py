"""How metrics are called on a page, and which one a table is sorted by."""

import re
from collections.abc import Sequence

from warehouse_sim.benchmark.rows.row import Row

_SPACE = "\u00a0"
_HEADLINES = ("dock_0mm", "add_adds_10pct", "add_10pct", "docked", "ap_box_50")
"""The number a forklift needs where there is one; else the fraction within a tenth of the diameter."""
_PATTERNS = (
    (r"dock_0mm", "docked"),
    (r"dock_nominal_0mm", "docked, nominal pockets"),
    (r"dock_(\d+)mm", r"docked, \1 mm to spare"),
    (r"dock_nominal_(\d+)mm", r"docked, nominal pockets, \1 mm to spare"),
    (r"add_adds_(\d+)pct", r"ADD(-S) < \1 % d"),
    (r"add_s_(\d+)pct", r"ADD-S < \1 % d"),
    (r"add_shape_(\d+)pct", r"ADD over all symmetries of the shape < \1 % d"),
    (r"add_(\d+)pct", r"ADD < \1 % d"),
    (r"(mssd|mspd)_(\d+)pct", r"\1 < \2 % d"),
    (r"auc_add_(\d+)pct", r"AUC of ADD to \1 % d"),
    (r"auc_add_(\d+)cm", r"AUC of ADD to \1 cm"),
    (r"pose_5cm_5deg", "5 cm 5°"),
    (r"ap_box_(\d+)", r"AP of boxes at \1 %"),
    (r"ap_mask_(\d+)", r"AP of masks at \1 %"),
    (r"swept_docked", "swept-volume check: docked"),
    (r"swept_agrees", "swept-volume check agrees"),
)
_OF_FOUND = "_of_found"


def metric_title(metric: str) -> str:
    """Return what a metric is called; one that is not known keeps its name."""
    base = metric.removesuffix(_OF_FOUND)
    for pattern, title in _PATTERNS:
        if found := re.fullmatch(pattern, base):
            text = found.expand(title).replace("mssd", "MSSD").replace("mspd", "MSPD")
            return _unbroken(text) + (" of what was found" if base != metric else "")
    return metric.replace("_", " ")


def headline(rows: Sequence[Row]) -> str:
    """Return the metric that rows are sorted by: the first of a fixed list that they have, else their own first."""
    metrics = dict.fromkeys(row.metric for row in rows)
    return next((name for name in _HEADLINES if name in metrics), next(iter(metrics), ""))


def _unbroken(text: str) -> str:
    """Keep a number with its unit and its sign."""
    return re.sub(r" (?=[%<°]|mm|cm|d\b|\d)", _SPACE, text)
