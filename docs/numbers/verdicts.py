"""What stored numbers say of a claim: it holds, it does not hold, or they cannot decide it; each with its reason.

A test of a claim names places of stored numbers:

- ``above: [a, b]``: a lies above b. The stored paired effect decides where there is one, by whether its 95 % interval
  excludes zero; else two intervals that do not meet.
- ``alike: [a, b]``: a and b differ by at most ``within`` points (2). Only a paired effect can confirm it.
- ``at_least: a`` or ``at_most: a`` with ``percent``: the whole interval, or the number itself at 100 and 0 %.
- ``narrower: [a, b]``: less lies between the quartiles of a's objects than of b's; the objects are resampled.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from docs.numbers.stored import Given, Number, Place, effect, number, place_of, rows

Verdict = Literal["holds", "does not hold", "cannot be decided"]
HOLDS: Verdict = "holds"
FAILS: Verdict = "does not hold"
OPEN: Verdict = "cannot be decided"
_WITHIN = 2.0
_RESAMPLES = 2_000


@dataclass(frozen=True)
class Outcome:
    """What a test came to."""

    verdict: Verdict
    why: str
    """The numbers behind it."""


@dataclass(frozen=True)
class Boxes:
    """Which groups of a suite are objects."""

    leave: tuple[str, ...]
    """Groups that are none."""
    least: int
    """Ground truths of an object that counts."""


def percent(found: Number, sign: str = "") -> str:
    """Return a number in per cent with its interval."""
    return f"{100 * found.value:{sign}.1f} [{100 * found.low:{sign}.1f}, {100 * found.high:{sign}.1f}]"


def decide(tests: Sequence[Mapping[str, Any]], at: Mapping[str, Any], boxes: Boxes | None = None) -> Outcome:
    """Return what all tests of a claim say together: one that fails decides, else one that is open.

    Args:
        tests: Each with one of the keys above.
        at: Where places lie unless they say otherwise.
        boxes: Which groups are objects.
    """
    outcomes = [_decide(test, at, boxes) for test in tests]
    verdicts = {item.verdict for item in outcomes}
    whole = FAILS if FAILS in verdicts else OPEN if OPEN in verdicts else HOLDS
    decisive = [item.why for item in outcomes if item.verdict == whole]
    return Outcome(whole, "; ".join(decisive))


def _decide(test: Mapping[str, Any], at: Mapping[str, Any], boxes: Boxes | None) -> Outcome:
    kind = next(name for name in _TESTS if name in test)
    given: Sequence[Given] = test[kind] if isinstance(test[kind], list) else [test[kind]]
    places = [place_of(at, item) for item in given]
    missing = [place for place in places if not rows(place)]
    if missing:
        return Outcome(OPEN, f"no stored result of {missing[0].differs()}")
    if kind == "narrower":
        assert boxes is not None
        return _narrower(places, boxes)
    return _TESTS[kind](places, test)


def _above(places: Sequence[Place], test: Mapping[str, Any]) -> Outcome:
    one, other = places
    paired = effect(one, other)
    if paired is not None:
        verdict = HOLDS if paired.low > 0 else FAILS if paired.high < 0 else OPEN
        return Outcome(verdict, _paired(one, other, paired))
    first, second = _numbers(places)
    verdict = HOLDS if first.low > second.high else FAILS if first.high < second.low else OPEN
    return Outcome(verdict, _side_by_side(places, verdict))


def _alike(places: Sequence[Place], test: Mapping[str, Any]) -> Outcome:
    one, other = places
    within, paired = test.get("within", _WITHIN) / 100, effect(one, other)
    if paired is not None:
        is_near = -within <= paired.low and paired.high <= within
        verdict = HOLDS if is_near else FAILS if paired.low > 0 or paired.high < 0 else OPEN
        return Outcome(verdict, _paired(one, other, paired))
    first, second = _numbers(places)
    verdict = FAILS if first.low > second.high or first.high < second.low else OPEN
    return Outcome(verdict, _side_by_side(places, verdict))


def _at_least(places: Sequence[Place], test: Mapping[str, Any]) -> Outcome:
    (found,), bound = _numbers(places), test["percent"] / 100
    holds = found.low >= bound or found.value == bound == 1.0
    return Outcome(HOLDS if holds else FAILS if found.high < bound else OPEN, f"{places[0].differs()} {percent(found)}")


def _at_most(places: Sequence[Place], test: Mapping[str, Any]) -> Outcome:
    (found,), bound = _numbers(places), test["percent"] / 100
    holds = found.high <= bound or found.value == bound == 0.0
    return Outcome(HOLDS if holds else FAILS if found.low > bound else OPEN, f"{places[0].differs()} {percent(found)}")


_TESTS: dict[str, Callable[[Sequence[Place], Mapping[str, Any]], Outcome]] = {
    "above": _above,
    "alike": _alike,
    "at_least": _at_least,
    "at_most": _at_most,
    "narrower": _above,
}


def values_of(place: Place, boxes: Boxes) -> dict[str, float]:
    """Return the stored fraction of each object of a suite that has enough ground truths."""
    found = rows(place, "group")
    return {row["group"]: row["value"] for row in found if row["group"] not in boxes.leave and row["n"] >= boxes.least}


def _narrower(places: Sequence[Place], boxes: Boxes) -> Outcome:
    one, other = (np.array(list(values_of(place, boxes).values())) for place in places)
    picks = np.random.default_rng(0).integers(len(one), size=(_RESAMPLES, len(one)))
    sampled = _between_quartiles(one[picks]) - _between_quartiles(other[picks])
    low, high = np.percentile(sampled, [2.5, 97.5])
    found = Number(float(_between_quartiles(one) - _between_quartiles(other)), float(low), float(high))
    verdict = HOLDS if found.high < 0 else FAILS if found.low > 0 else OPEN
    return Outcome(verdict, f"between the quartiles {_paired(places[0], places[1], found)} over {len(one)} objects")


def _between_quartiles(values: np.ndarray) -> np.ndarray:
    low, high = np.percentile(values, [25, 75], axis=-1)
    return np.asarray(high - low)


def _numbers(places: Sequence[Place]) -> list[Number]:
    return [found for place in places if (found := number(place)) is not None]


def _paired(one: Place, other: Place, found: Number) -> str:
    return f"{one.differs(other)} minus {other.differs(one)} is {percent(found, '+')} points"


def _side_by_side(places: Sequence[Place], verdict: Verdict) -> str:
    one, other = places
    first, second = _numbers(places)
    meet = "which meet" if verdict == OPEN else "which lie apart"
    return f"{one.differs(other)} {percent(first)} and {other.differs(one)} {percent(second)}, {meet}"
