"""A leaderboard: who is how good by the headline metric of a table, and who are too close to rank."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from warehouse_sim.benchmark.report.looks import Kind, family_of, headline, kind_of
from warehouse_sim.benchmark.result import SuiteResult
from warehouse_sim.benchmark.rows.row import Row, Table

RANKED: tuple[Table, ...] = ("scores", "faces", "simulated", "driven", "negatives", "detection")


@dataclass(frozen=True)
class Place:
    """A line of a leaderboard."""

    name: str
    kind: Kind
    ranks: tuple[int, int] | None
    """Best and worst rank that the intervals allow: beside whom it lies is open where others share them. None for
    references, and for who has no number in the headline metric."""
    cells: dict[str, Row]
    """By metric."""
    seconds: Row | None = None
    """How long it took for an image, where that is known."""

    @property
    def leads(self) -> bool:
        """Whether no other is better beyond the intervals."""
        return self.ranks is not None and self.ranks[0] == 1

    @property
    def rank(self) -> str:
        """The rank in words."""
        if self.ranks is None:
            return ""
        best, worst = self.ranks
        return str(best) if best == worst else f"{best}–{worst}"


@dataclass(frozen=True)
class Board:
    """A leaderboard of one table under one condition."""

    table: Table
    condition: str
    group: str
    metric: str
    """What it is sorted by."""
    metrics: tuple[str, ...]
    """All of its columns, the headline first."""
    places: tuple[Place, ...]

    @property
    def is_timed(self) -> bool:
        """Whether the run time of anybody is known."""
        return any(place.seconds is not None for place in self.places)


def boards(result: SuiteResult) -> list[Board]:
    """Return the leaderboards of a result, table by table.

    Of ``scores`` those of all ground truths are taken; a condition that paired effects hold against another one has
    none, since its effects are shown. Of a training that was scored at several lengths the longest counts.
    """
    found = []
    for table in RANKED:
        rows = [row for row in result.rows if row.table == table]
        if table == "scores":
            rows = [row for row in rows if row.group == "all" and row.condition not in _changed(result)] or [
                row for row in rows if row.group == "all"
            ]
            left_out = shorter(result)
            rows = [row for row in rows if row.estimator not in left_out]
        for condition, group in dict.fromkeys((row.condition, row.group) for row in rows):
            mine = [row for row in rows if (row.condition, row.group) == (condition, group)]
            timed = {row.estimator: row for row in result.rows if (row.table, row.condition) == ("time", condition)}
            found.append(board(mine, timed if table == "scores" else {}))
    return found


def board(rows: Sequence[Row], seconds: Mapping[str, Row] = {}) -> Board:
    """Return the leaderboard of the rows of one table, condition and group; there is at least one.

    Ranks count those who are clear: whose whole interval lies beyond. References are placed by their value but have no
    rank and push nobody down.

    Args:
        rows: What is ranked.
        seconds: Run times by estimator, which rank nobody.
    """
    metric = headline(rows)
    cells: dict[str, dict[str, Row]] = {}
    for row in rows:
        cells.setdefault(row.estimator, {})[row.metric] = row
    ranked = {name: kept[metric] for name, kept in cells.items() if metric in kept and not kind_of(name)}
    places = [
        Place(
            name,
            kind_of(name),
            ranks(ranked[name], list(ranked.values())) if name in ranked else None,
            kept,
            seconds.get(name),
        )
        for name, kept in cells.items()
    ]
    places.sort(key=lambda place: _order(place, metric))
    metrics = dict.fromkeys([metric, *(row.metric for row in rows)])
    return Board(rows[0].table, rows[0].condition, rows[0].group, metric, tuple(metrics), tuple(places))


def ranks(row: Row, all_rows: Sequence[Row]) -> tuple[int, int]:
    """Return the best and the worst rank that the intervals of some rows allow one of them."""
    better = sum(other.interval[0] > row.interval[1] for other in all_rows)
    worse = sum(other.interval[1] < row.interval[0] for other in all_rows)
    return better + 1, len(all_rows) - worse


def _order(place: Place, metric: str) -> tuple[bool, float, float, str]:
    row = place.cells.get(metric)
    return (True, 0.0, 0.0, place.name) if row is None else (False, -row.value, -row.interval[0], place.name)


def _changed(result: SuiteResult) -> set[str]:
    """Return the conditions that effects hold against another condition."""
    names = {row.condition for row in result.rows if row.table == "scores"}
    return {row.condition for row in result.rows if row.table == "effects" and row.against in names - {row.condition}}


def shorter(result: SuiteResult) -> set[str]:
    """Return who was trained for less than another one of its name."""
    longest: dict[str, int] = {}
    for item in result.estimators:
        if item.samples is not None:
            longest[family_of(item)] = max(item.samples, longest.get(family_of(item), 0))
    return {item.name for item in result.estimators if (item.samples or 0) < longest.get(family_of(item), 0)}


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
    return sorted(lines, key=_by_leads)


def _by_leads(item: Standing) -> tuple[bool, float, int, str]:
    return bool(item.kind), -item.leads / len(item.places), -len(item.places), item.name


def first_boards(boards_of: Mapping[str, Sequence[Board]]) -> dict[str, Board]:
    """Return the first leaderboard of each suite that has one."""
    return {suite: boards[0] for suite, boards in boards_of.items() if boards}
