"""The colour and mark of each estimator in all charts of a result; references are grey."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any, Literal

from warehouse_sim.benchmark.result import EstimatorFacts
from warehouse_sim.evaluation.report.figure import PALETTE

Kind = Literal["", "oracle", "chance", "baseline"]
_KINDS: dict[str, Kind] = {
    "oracle": "oracle",
    "shuffled": "chance",
    "rectangle-fit": "baseline",
    "plane and rectangle": "baseline",
}
_COLORS = (*PALETTE[:5], "#b08a00", "#1797b5", "#d35fb0", "#7a9a1d", "#9a6b48")
_MARKS = (("o", "●"), ("s", "■"), ("^", "▲"), ("D", "◆"), ("v", "▼"), ("P", "✚"), ("X", "✖"))
_GREY = "#7d8792"
_REFERENCES: dict[str, tuple[tuple[str, str], Any]] = {
    "oracle": (("|", "┆"), (0, (1, 2))),
    "chance": (("x", "×"), (0, (1, 2))),
    "baseline": (("*", "★"), (0, (5, 2))),
}
_LONGEST = 34


@dataclass(frozen=True)
class Look:
    """Colour and mark of an estimator in charts."""

    number: int
    """Its place among the estimators of the result; names in a chart's elements are made of it."""
    name: str
    kind: Kind
    """Which reference it is: the ground truth, chance, a baseline; empty for all others."""
    color: str
    mark: str
    """Of matplotlib."""
    glyph: str
    """The mark as a letter, for the key."""
    dash: Any = "-"

    @property
    def short(self) -> str:
        """The name, cut in the middle where it is too long for a chart."""
        return shortened(self.name)

    @property
    def is_bound(self) -> bool:
        """Whether it is the ground truth or chance: bounds of a score, not competitors."""
        return self.kind in ("oracle", "chance")


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
    for number, item in enumerate(estimators):
        kind, family = kind_of(item.name), family_of(item)
        if kind:
            (mark, glyph), dash = _REFERENCES[kind]
            found[item.name] = Look(number, item.name, kind, _GREY, mark, glyph, dash)
            continue
        if family not in taken:
            taken[family] = next(free)
        mark, glyph = _MARKS[taken[family] % len(_MARKS)]
        found[item.name] = Look(number, item.name, kind, _COLORS[taken[family] % len(_COLORS)], mark, glyph)
    return found


def family_of(item: EstimatorFacts) -> str:
    """Return the name without the steps that a suite trained it for."""
    return item.name.rpartition("@")[0] or item.name if item.samples is not None else item.name
