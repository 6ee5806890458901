"""All cases there are: one module a kind of input, each with ``cases(stock)``."""

from collections.abc import Iterator

from benchmarks.acceptance.hostile.case import Case
from benchmarks.acceptance.hostile.cases import command_lines, datasets, objects, predictions, recipes, runs
from benchmarks.acceptance.hostile.stock import Stock


def all_cases(stock: Stock) -> Iterator[Case]:
    """Yield every case, always in the same order."""
    for module in (recipes, objects, datasets, predictions, runs, command_lines):
        yield from module.cases(stock)
