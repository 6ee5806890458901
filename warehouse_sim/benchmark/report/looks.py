"""How everybody of a result looks and is named in all of its charts: one colour and mark each, references in grey."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from typing import Literal

from warehouse_sim.benchmark.result import EstimatorFacts
from warehouse_sim.benchmark.rows.row import Row
from warehouse_sim.evaluation.report.figure import PALETTE

Kind = Literal["", "oracle", "ceiling", "chance", "baseline"]
_KINDS: dict[str, Kind] = {
    "oracle": "oracle",
    "oracle-icp": "ceiling",
    "shuffled": "chance",
    "rectangle-fit": "baseline",
    "plane and rectangle": "baseline",
}
_COLORS = (*PALETTE[:5], "#b08a00", "#1797b5", "#d35fb0", "#7a9a1d", "#9a6b48")
_MARKS = (
    *(("circle", "●"), ("square", "■"), ("triangle-up", "▲"), ("diamond", "◆")),
    *(("triangle-down", "▼"), ("cross", "✚"), ("x", "✖")),
)
_GREY = "#7d8792"
_REFERENCES: dict[str, tuple[tuple[str, str], str]] = {
    "oracle": (("line-ns-open", "┆"), "dot"),
    "ceiling": (("line-ew-open", "┈"), "dashdot"),
    "chance": (("x-thin-open", "×"), "dot"),
    "baseline": (("star", "★"), "dash"),
}
_LONGEST = 34


@dataclass(frozen=True)
class Look:
    """Colour and mark of an estimator in charts."""

    name: str
    kind: Kind
    """Which reference it is: the ground truth, the ceiling of the sensor, chance, a baseline; empty for all others."""
    color: str
    mark: str
    """Of Plotly."""
    glyph: str
    """The mark as a letter, for the key."""
    dash: str = "solid"
    """Of Plotly."""

    @property
    def short(self) -> str:
        """The name, cut in the middle where it is too long for a chart."""
        return shortened(self.name)

    @property
    def is_bound(self) -> bool:
        """Whether it is the ground truth, the sensor's ceiling or chance: bounds of a score, not competitors."""
        return self.kind in ("oracle", "ceiling", "chance")


def shortened(text: str) -> str:
    """Return a text of at most 34 signs in one line, the middle left out."""
    text = " ".join(text.split())
    half = (_LONGEST - 1) // 2
    return text if len(text) <= _LONGEST else f"{text[:half]}…{text[-half:]}"


def kind_of(name: str) -> Kind:
    """Return what an estimator is a reference for; ``+`` words change nothing about that."""
    return _KINDS.get(name.partition("+")[0], "")


def looks_of(estimators: Sequence[EstimatorFacts]) -> dict[str, Look]:
    """Return the look of each estimator; lengths of one training (``name@steps``) share theirs."""
    found: dict[str, Look] = {}
    taken: dict[str, int] = {}
    free = count()
    for item in estimators:
        kind, family = kind_of(item.name), family_of(item)
        if kind:
            (mark, glyph), dash = _REFERENCES[kind]
            found[item.name] = Look(item.name, kind, _GREY, mark, glyph, dash)
            continue
        if family not in taken:
            taken[family] = next(free)
        mark, glyph = _MARKS[taken[family] % len(_MARKS)]
        found[item.name] = Look(item.name, kind, _COLORS[taken[family] % len(_COLORS)], mark, glyph)
    return found


def family_of(item: EstimatorFacts) -> str:
    """Return the name without the steps that a suite trained it for."""
    return item.name.rpartition("@")[0] or item.name if item.samples is not None else item.name


_SPACE = "\u00a0"
_HEADLINES = ("dock_0mm", "add_adds_10pct", "add_10pct", "docked", "ap_box_50")
"""The number a forklift needs where there is one; else the fraction within a tenth of the diameter."""
_PATTERNS = (
    (r"dock_0mm", "docked"),
    (r"dock_nominal_0mm", "docked, nominal pockets"),
    (r"dock_stack_0mm", "stacks docked"),
    (r"dock_stack_(\d+)mm", r"stacks docked, \1 mm to spare"),
    (r"dock_gate_50mm_3deg_40mm", "50 mm sideways, 3° yaw, 40 mm up"),
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
    (r"no_unwarned_failure", "no failure without warning"),
    (r"ap_mssd_mm", "AP of poses, MSSD 2-20 mm"),
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
