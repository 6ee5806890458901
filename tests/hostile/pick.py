"""Which of all cases a run tries: in turn from every kind of input and mutation, so that no rule is left out."""

from collections import defaultdict
from collections.abc import Iterator

from tests.hostile.case import Case, stream
from tests.hostile.cases import calls, command_lines, files, recipes
from tests.hostile.stock import Stock

# Fractions of a run, by how much there is to get wrong.
_FRACTIONS = {
    "recipe": 0.24,
    "call recipe": 0.08,
    "object": 0.04,
    "call object": 0.03,
    "dataset": 0.18,
    "call dataset": 0.06,
    "run": 0.03,
    "call run": 0.02,
    "result": 0.05,
    "call result": 0.01,
    "command line": 0.06,
    "call": 0.20,
}


def all_cases(stock: Stock) -> Iterator[Case]:
    """Yield every case of the stock, always in the same order."""
    for module in (recipes, files, command_lines, calls):
        yield from module.cases(stock)


def pick(stock: Stock, count: int, seed: int) -> list[Case]:
    """Return ``count`` cases in an order that mixes the kinds; fewer where the stock is not whole."""
    by_kind: dict[str, dict[str, list[Case]]] = defaultdict(lambda: defaultdict(list))
    for case in all_cases(stock):
        by_kind[case.kind][f"{case.mutation} {case.expect}"].append(case)
    rng = stream("pick", seed)
    chosen: list[Case] = []
    for kind, groups in by_kind.items():
        for group in groups.values():
            rng.shuffle(group)
        turns = range(max(map(len, groups.values())))
        in_turn = [group[turn] for turn in turns for group in groups.values() if turn < len(group)]
        chosen += in_turn[: round(count * _FRACTIONS[kind])]
    rng.shuffle(chosen)
    return chosen
