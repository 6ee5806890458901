"""What is drawn is what the result says: every chart is read back from its SVG by its ticks and paths."""

import numpy as np
import pytest

from tests.benchmark.report.drawn import Drawn
from tests.benchmark.report.made import DISTANCES, everything, result, row, spread
from warehouse_sim.benchmark.report.looks import looks_of
from warehouse_sim.benchmark.report.panels import Panel, panels
from warehouse_sim.benchmark.result import EstimatorFacts, SuiteResult
from warehouse_sim.benchmark.rows.row import Row

MADE = everything()
NEAR = 0.02
"""In per cent; paths are written with six digits."""


def panel(made: SuiteResult, title: str) -> tuple[Panel, Drawn]:
    (found,) = [item for item in panels(made) if item.title == title]
    return found, Drawn(found.draw("a-"), "a-")


def rows_of(made: SuiteResult, **wanted: str) -> list[Row]:
    return [item for item in made.rows if all(getattr(item, name) == value for name, value in wanted.items())]


def number(made: SuiteResult, name: str) -> int:
    return [item.name for item in made.estimators].index(name)


@pytest.mark.parametrize(
    ("table", "group", "title", "start", "first"),
    [
        ("curves", "all", "Accuracy over threshold, all", "add_", 1),
        ("curves", "pallet", "Accuracy over threshold, pallet", "add_", 1),
        ("precision", "pallet", "Precision by recall, pallet", "at_recall_", 10),
    ],
)
def test_lines_over_numbers_are_the_numbers(table: str, group: str, title: str, start: str, first: int) -> None:
    _, drawn = panel(MADE, title)
    x, y = drawn.x(), drawn.y()
    for name in ("net", "other+icp", "rectangle-fit", "oracle"):
        rows = rows_of(MADE, table=table, group=group, estimator=name)
        marks = drawn.marks(f"points-{number(MADE, name)}")
        assert len(marks) == len(rows) == 10
        for place, (item, (left, top)) in enumerate(zip(rows, marks, strict=True)):
            assert x(left) == pytest.approx(first * (place + 1), abs=NEAR)
            assert y(top) == pytest.approx(100 * item.value, abs=NEAR)
        paths = drawn.paths(f"interval-{number(MADE, name)}") if name != "oracle" else []
        ends = sorted(y(top) for path in paths for _, top in path)
        for item in rows if paths else []:
            for end in item.interval:
                assert np.abs(np.array(ends) - 100 * end).min() < NEAR


def test_the_ground_truth_and_chance_are_lines_without_an_interval() -> None:
    _, drawn = panel(MADE, "Accuracy over threshold, all")
    assert {f"points-{k}" for k in range(5)} <= set(drawn.named)
    assert {name for name in drawn.named if name.startswith("interval-")} == {"interval-2", "interval-3", "interval-4"}


def test_scores_by_distance_stand_at_their_bin_with_their_interval() -> None:
    found, drawn = panel(MADE, "docked by distance, set")
    assert found.first
    assert [label for label, _ in drawn.x_ticks] == ["0-7 (40)", "7-15 (40)", "15-25 (40)"]
    y = drawn.y()
    for name in ("rectangle-fit", "net", "other+icp"):
        points = drawn.marks(f"points-{number(MADE, name)}")
        intervals = drawn.paths(f"interval-{number(MADE, name)}")
        for bin_name, (left, top), interval in zip(DISTANCES, points, intervals, strict=True):
            (item,) = rows_of(MADE, table="scores", group=bin_name, estimator=name, metric="dock_0mm")
            assert drawn.category(left).partition(" ")[0] == bin_name.removesuffix(" m")
            assert y(top) == pytest.approx(100 * item.value, abs=NEAR)
            assert [y(top) for _, top in interval] == pytest.approx([100 * end for end in item.interval], abs=NEAR)
            assert {round(at, 4) for at, _ in interval} == {round(left, 4)}


def test_bins_are_in_the_order_of_their_numbers_and_one_more_grouping_has_a_chart_of_its_own() -> None:
    rng = np.random.default_rng(1)
    labels = ("7-15 m", "0-7 m", "25-35 m", "15-25 m")
    rows = [row(rng, "scores", "net", label, "found") for label in labels]
    rows += [row(rng, "scores", "net", f"{label}, at least 50 points", "found") for label in labels[:2]]
    made = result(rows)
    titles = [item.title for item in panels(made)]
    assert titles == ["found by distance", "found by distance, at least 50 points"]
    _, drawn = panel(made, titles[0])
    assert [label.partition(" ")[0] for label, _ in drawn.x_ticks] == ["0-7", "7-15", "15-25", "25-35"]
    by_bin = {drawn.category(left).partition(" ")[0]: drawn.y()(top) for left, top in drawn.marks("points-0")}
    assert by_bin == pytest.approx(
        {item.group.removesuffix(" m"): 100 * item.value for item in rows if "," not in item.group}, abs=NEAR
    )


def test_effects_are_drawn_with_their_interval_and_filled_only_where_it_leaves_zero_out() -> None:
    _, drawn = panel(MADE, "docked gained or lost by light, against base")
    assert [label for label, _ in drawn.y_ticks] == ["dim", "night", "off"]
    x, seen, hollow = drawn.x(), [], 0
    for name in [item for item in drawn.named if item.startswith("points-")]:
        _, who, _ = name.split("-")
        ((left, top),) = drawn.marks(name)
        label = f"light: {drawn.level(top)}"
        estimator = MADE.estimators[int(who)].name
        (item,) = rows_of(MADE, table="effects", group=label, estimator=estimator, metric="dock_0mm")
        (interval,) = drawn.paths(name.replace("points", "interval"))
        assert x(left) == pytest.approx(100 * item.value, abs=NEAR)
        assert [x(at) for at, _ in interval] == pytest.approx([100 * end for end in item.interval], abs=NEAR)
        low, high = item.interval
        assert drawn.is_hollow(name) == (low <= 0.0 <= high)
        hollow += drawn.is_hollow(name)
        seen.append((estimator, label))
    assert len(seen) == len(set(seen)) == 3 * 3, "the ground truth and chance have no place there"
    assert 0 < hollow < 9


def test_one_level_alone_names_the_estimators() -> None:
    rng = np.random.default_rng(2)
    rows = [row(rng, "effects", name, "fusion", "dock_0mm", against="original") for name in ("early", "late")]
    _, drawn = panel(result(rows), "docked gained or lost by fusion, against original")
    assert [label for label, _ in drawn.y_ticks] == ["early", "late"]
    for place, item in enumerate(rows):
        ((left, top),) = drawn.marks(f"points-{place}-{place}")
        assert drawn.level(top) == item.estimator
        assert drawn.x()(left) == pytest.approx(100 * item.value, abs=NEAR)


def test_boxes_are_the_quantiles() -> None:
    _, drawn = panel(MADE, "How the error is spread, all")
    x = drawn.x(logarithmic=True)
    for name in ("net", "other+icp"):
        who, of_name = number(MADE, name), rows_of(MADE, table="spread", estimator=name)
        values = [100 * item.value for item in of_name]
        corners = [x(at) for at, _ in drawn.paths(f"box-{who}")[0]]
        assert [min(corners), max(corners)] == pytest.approx([values[1], values[3]], rel=1e-3)
        ends = sorted(x(at) for path in drawn.paths(f"whisker-{who}") for at, _ in path)
        assert ends == pytest.approx([values[0], values[1], values[3], values[4]], rel=1e-3)
        ((left, top),) = drawn.marks(f"points-{who}")
        assert x(left) == pytest.approx(values[2], rel=1e-3)
        assert drawn.level(top) == name
        (interval,) = drawn.paths(f"interval-{who}")
        assert [x(at) for at, _ in interval] == pytest.approx([100 * end for end in of_name[2].interval], rel=1e-3)


def test_what_is_below_a_thousandth_is_drawn_there() -> None:
    rows = [
        Row("spread", "oracle", "set", "all", item.metric, 0.0, (0.0, 0.1), 40, 4)
        for item in spread(np.random.default_rng(0), "oracle")
    ]
    _, drawn = panel(result(rows), "How the error is spread, all")
    ((left, _),) = drawn.marks("points-0")
    assert drawn.x(logarithmic=True)(left) == pytest.approx(0.1, rel=1e-3)


def test_score_against_samples_seen() -> None:
    rng = np.random.default_rng(4)
    facts = [EstimatorFacts("rectangle-fit", 0)]
    facts += [EstimatorFacts(f"{name}@{n}", 3, "", 32 * n) for name in ("early", "late") for n in (2000, 10000, 4000)]
    made = result([row(rng, "scores", item.name, "all", "dock_0mm") for item in facts], facts)
    _, drawn = panel(made, "docked over samples seen")
    x, y = drawn.x(), drawn.y()
    for head, name in ((1, "early"), (4, "late")):
        points = {round(x(left), 1): y(top) for left, top in drawn.marks(f"points-{head}")}
        wanted = {32 * n / 1000: 100 * rows_of(made, estimator=f"{name}@{n}")[0].value for n in (2000, 4000, 10000)}
        assert points == pytest.approx(wanted, abs=NEAR)
    level = [(x(left), y(top)) for left, top in drawn.marks("points-0")]
    value = 100 * made.rows[0].value
    assert level[0] == pytest.approx((64.0, value), abs=NEAR)
    assert level[1] == pytest.approx((320.0, value), abs=NEAR)


def test_margins_are_drawn_in_their_order() -> None:
    rng = np.random.default_rng(5)
    rows = [row(rng, "scores", "net", "all", f"dock_{mm}mm") for mm in (20, 0, 10)]
    _, drawn = panel(result(rows), "Docked over the clearance to spare")
    assert [label for label, _ in drawn.x_ticks] == ["0", "10", "20"]
    found = {drawn.category(left): drawn.y()(top) for left, top in drawn.marks("points-0")}
    assert found == pytest.approx({item.metric[5:-2]: 100 * item.value for item in rows}, abs=NEAR)


def test_where_there_is_nothing_there_is_no_chart() -> None:
    assert list(panels(result([]))) == []
    only_bounds = everything(("oracle", "shuffled"))
    assert [item.title for item in panels(only_bounds)] == ["How the error is spread, all"]


def test_colours_and_marks_together_are_nobody_elses() -> None:
    facts = [EstimatorFacts(f"net {k}", 1) for k in range(40)] + [EstimatorFacts("rectangle-fit+lidar", 0)]
    looks = looks_of(facts)
    assert len({(look.color, look.mark) for look in looks.values()}) == 41
    assert looks["rectangle-fit+lidar"].kind == "baseline"
