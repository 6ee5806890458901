"""Which of all cases a run tries: in turn from every kind of file and mutation, so that no rule is left out."""

import fnmatch
from collections import defaultdict
from collections.abc import Iterable, Sequence

from benchmarks.acceptance.hostile.case import Case
from benchmarks.acceptance.hostile.draw import stream

# Fractions of a run, by how much there is to get wrong.
_FRACTIONS = {
    "recipe": 0.38,
    "rig": 0.07,
    "object": 0.12,
    "dataset": 0.22,
    "predictions": 0.05,
    "run": 0.06,
    "command line": 0.10,
}


def pick(cases: Iterable[Case], count: int, seed: int) -> list[Case]:
    """Return ``count`` cases, or all if there are fewer, in an order that mixes the kinds."""
    by_kind: dict[str, dict[str, list[Case]]] = defaultdict(lambda: defaultdict(list))
    for case in cases:
        by_kind[case.kind][f"{case.mutation} {case.expect}"].append(case)
    rng = stream("pick", seed)
    chosen: list[Case] = []
    for kind, groups in by_kind.items():
        for group in groups.values():
            rng.shuffle(group)
        chosen += _in_turn(list(groups.values()), round(count * _FRACTIONS[kind]))
    rng.shuffle(chosen)
    return chosen[:count]


def only(cases: Iterable[Case], patterns: Sequence[str]) -> list[Case]:
    """Return the cases whose id is, or fits, one of ``patterns`` (``*`` stands for anything)."""
    escaped = [pattern.replace("[", "[[]") for pattern in patterns]
    return [case for case in cases if any(fnmatch.fnmatchcase(case.id, pattern) for pattern in escaped)]


def _in_turn(groups: list[list[Case]], count: int) -> list[Case]:
    """Return ``count`` cases, one of each group in turn."""
    chosen: list[Case] = []
    for turn in range(max(map(len, groups), default=0)):
        for group in groups:
            if turn < len(group) and len(chosen) < count:
                chosen.append(group[turn])
    return chosen
