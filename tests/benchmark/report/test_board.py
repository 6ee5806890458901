"""Leaderboards: order, ranks that intervals leave open, references beside them."""

import itertools

import numpy as np
import pytest

from tests.benchmark.report.made import everything, result, row
from warehouse_sim.benchmark.report.board import board, boards, first_boards, ranks, standings
from warehouse_sim.benchmark.report.looks import headline, metric_title
from warehouse_sim.benchmark.result import EstimatorFacts
from warehouse_sim.benchmark.rows.row import Row


def scored(name: str, value: float, low: float, high: float, condition: str = "set", metric: str = "dock_0mm") -> Row:
    return Row("scores", name, condition, "all", metric, value, (low, high), 40, 4)


ROWS = (
    scored("shuffled", 0.01, 0.0, 0.1),
    scored("behind", 0.3, 0.2, 0.4),
    scored("first", 0.9, 0.8, 0.95),
    scored("rectangle-fit+lidar", 0.97, 0.96, 0.98),
    scored("tied", 0.85, 0.7, 0.9),
    scored("oracle", 1.0, 0.9, 1.0),
    scored("last", 0.25, 0.1, 0.35),
)


def test_the_order_is_by_value_and_ties_share_their_ranks() -> None:
    found = board(ROWS)
    assert [(place.name, place.rank, place.kind) for place in found.places] == [
        ("oracle", "", "oracle"),
        ("rectangle-fit+lidar", "", "baseline"),
        ("first", "1–2", ""),
        ("tied", "1–2", ""),
        ("behind", "3–4", ""),
        ("last", "3–4", ""),
        ("shuffled", "", "chance"),
    ]
    assert [place.name for place in found.places if place.leads] == ["first", "tied"]


def test_ranks_are_those_of_some_order_that_the_intervals_allow() -> None:
    rng = np.random.default_rng(7)
    for _ in range(30):
        rows = [row(rng, "scores", f"net {k}", "all", "dock_0mm") for k in range(5)]
        allowed: dict[str, set[int]] = {}
        for order in itertools.permutations(rows):
            # Nobody stands above whom his whole interval lies below.
            if all(one.interval[1] >= other.interval[0] for one, other in itertools.combinations(order, 2)):
                for rank, item in enumerate(order, 1):
                    allowed.setdefault(item.estimator, set()).add(rank)
        for item in rows:
            best, worst = ranks(item, rows)
            assert allowed[item.estimator] == set(range(best, worst + 1))


def test_who_has_no_headline_number_is_last_and_has_no_rank() -> None:
    rows = [*ROWS, scored("aside", 0.99, 0.9, 1.0, metric="add_10pct")]
    last = board(rows).places[-1]
    assert (last.name, last.rank) == ("aside", "")
    assert board(rows).metric == "dock_0mm"


def test_the_headline_is_docking_where_there_is_docking() -> None:
    rng = np.random.default_rng(0)
    metrics = ("found", "add_10pct", "dock_0mm")
    rows = [row(rng, "scores", "net", "all", name) for name in metrics]
    assert [headline(rows), headline(rows[:2]), headline(rows[:1]), headline([])] == [
        "dock_0mm",
        "add_10pct",
        "found",
        "",
    ]


def test_changed_conditions_have_no_board_since_effects_show_them() -> None:
    rows = [scored("net", 0.5, 0.4, 0.6, name) for name in ("exact", "dilated", "named")]
    effect = Row("effects", "net", "dilated", "error: dilated", "dock_0mm", -0.1, (-0.2, 0.0), 40, 4, 0, "exact")
    assert [item.condition for item in boards(result([*rows, effect]))] == ["exact", "named"]
    of_paired_variants = Row("effects", "net", "exact", "light: dim", "dock_0mm", -0.1, (-0.2, 0.0), 40, 4, 0, "base")
    assert [item.condition for item in boards(result([*rows, of_paired_variants]))] == ["exact", "dilated", "named"]


def test_of_a_training_the_longest_counts() -> None:
    facts = [EstimatorFacts(f"early@{n}", 3, "", 32 * n) for n in (2000, 10000, 4000)] + [EstimatorFacts("net", 1)]
    rows = [scored(item.name, 0.5, 0.4, 0.6) for item in facts]
    (found,) = boards(result(rows, facts))
    assert {place.name for place in found.places} == {"early@10000", "net"}


def test_every_table_that_ranks_has_boards() -> None:
    found = boards(everything())
    assert [(item.table, item.condition, item.metric) for item in found] == [
        ("scores", "set", "dock_0mm"),
        ("scores", "dilated", "dock_0mm"),
        ("simulated", "set", "docked"),
        ("driven", "set", "docked"),
        ("detection", "set", "ap_box_50"),
    ]
    assert boards(result([])) == []


def test_across_suites_leads_are_counted_and_references_come_last() -> None:
    one = result(
        [scored("a", 0.9, 0.8, 1.0), scored("b", 0.5, 0.4, 0.6), scored("oracle", 1.0, 0.9, 1.0)], suite="x-v1"
    )
    two = result(
        [scored("a", 0.5, 0.2, 0.8), scored("b", 0.6, 0.5, 0.7), scored("oracle", 1.0, 0.9, 1.0)], suite="y-v1"
    )
    three = result([scored("alone", 0.5, 0.2, 0.8), scored("b", 0.6, 0.5, 0.7)], suite="z-v1")
    found = standings(first_boards({item.suite: boards(item) for item in (one, two, three)}))
    assert [(item.name, item.leads, len(item.places)) for item in found] == [("a", 2, 2), ("b", 2, 3), ("oracle", 0, 2)]


@pytest.mark.parametrize(
    ("metric", "title"),
    [
        ("add_5pct", "ADD < 5 % d"),
        ("add_10pct_of_found", "ADD < 10 % d of what was found"),
        ("add_adds_10pct", "ADD(-S) < 10 % d"),
        ("mssd_5pct", "MSSD < 5 % d"),
        ("dock_nominal_20mm", "docked, nominal pockets, 20 mm to spare"),
        ("pose_5cm_5deg", "5 cm 5°"),
        ("of_a_stranger", "of a stranger"),
    ],
)
def test_metrics_are_called_by_words(metric: str, title: str) -> None:
    assert metric_title(metric).replace("\u00a0", " ") == title
