"""The leaderboard across suites: the headline number of each estimator in each suite."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from warehouse_sim.benchmark.report.board import Board, Place
from warehouse_sim.benchmark.report.looks import Kind


@dataclass(frozen=True)
class Standing:
    """Where an estimator stands in all suites."""

    name: str
    kind: Kind
    places: dict[str, Place]
    """By suite; suites without it are absent."""
    leads: int
    """In how many suites no other is better beyond the intervals."""


def standings(first_boards: Mapping[str, Board]) -> list[Standing]:
    """Return the estimators of at least two suites, the most frequent leader first.

    There is no mean over suites: they measure different things on different data.

    Args:
        first_boards: One leaderboard of each suite.
    """
    found: dict[str, dict[str, Place]] = {}
    for suite, board in first_boards.items():
        for place in board.places:
            if board.metric in place.cells:
                found.setdefault(place.name, {})[suite] = place
    lines = [
        Standing(name, next(iter(places.values())).kind, places, sum(place.leads for place in places.values()))
        for name, places in found.items()
        if len(places) > 1
    ]
    return sorted(lines, key=_order)


def _order(item: Standing) -> tuple[bool, float, int, str]:
    return bool(item.kind), -item.leads / len(item.places), -len(item.places), item.name


def first_boards(boards_of: Mapping[str, Sequence[Board]]) -> dict[str, Board]:
    """Return the first leaderboard of each suite that has one."""
    return {suite: boards[0] for suite, boards in boards_of.items() if boards}
