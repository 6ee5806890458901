"""What is plotted is what the result says: every chart is read back from its figure."""

from typing import Any

import numpy as np
import pytest

from tests.benchmark.report.made import DISTANCES, everything, result, row, spread
from warehouse_sim.benchmark.report.looks import looks_of
from warehouse_sim.benchmark.report.panels import Panel, panels
from warehouse_sim.benchmark.result import EstimatorFacts, SuiteResult
from warehouse_sim.benchmark.rows.row import Row

MADE = everything()
NEAR = 0.06
"""In per cent; figures have four digits."""


class Figure:
    """A figure: its traces by name and the names along its axes."""

    def __init__(self, figure: dict[str, Any]) -> None:
        self.traces = {trace["name"]: trace for trace in figure["data"]}
        self.layout = figure["layout"]

    def names(self, along: str) -> dict[float, str]:
        axis = self.layout[f"{along}axis"]
        return dict(zip(axis["tickvals"], axis["ticktext"], strict=True))

    def named(self, along: str, at: float) -> str:
        """Return the name of the nearest tick."""
        names = self.names(along)
        return names[min(names, key=lambda place: abs(place - at))]


def ends(trace: dict[str, Any], along: str) -> list[tuple[float, float]]:
    """Return the intervals around the values of a trace."""
    given = trace[f"error_{along}"]
    rows = zip(trace[along], given["arrayminus"], given["array"], strict=True)
    return [(value - below, value + above) for value, below, above in rows]


def panel(made: SuiteResult, title: str) -> tuple[Panel, Figure]:
    (found,) = [item for item in panels(made) if item.title == title]
    return found, Figure(found.plot())


def rows_of(made: SuiteResult, **wanted: str) -> list[Row]:
    return [item for item in made.rows if all(getattr(item, name) == value for name, value in wanted.items())]


def percent(item: Row) -> tuple[float, tuple[float, float]]:
    return 100 * item.value, (100 * item.interval[0], 100 * item.interval[1])


@pytest.mark.parametrize(
    ("table", "group", "title", "first"),
    [
        ("curves", "all", "Accuracy over threshold, all", 1),
        ("curves", "pallet", "Accuracy over threshold, pallet", 1),
        ("precision", "pallet", "Precision by recall, pallet", 10),
    ],
)
def test_lines_over_numbers_are_the_numbers(table: str, group: str, title: str, first: int) -> None:
    _, figure = panel(MADE, title)
    for name in ("net", "other+icp", "rectangle-fit", "oracle"):
        rows, trace = rows_of(MADE, table=table, group=group, estimator=name), figure.traces[name]
        assert trace["x"] == [first * (place + 1) for place in range(10)]
        assert trace["y"] == pytest.approx([100 * item.value for item in rows], abs=NEAR)
        if name != "oracle":
            assert np.array(ends(trace, "y")) == pytest.approx(np.array([percent(r)[1] for r in rows]), abs=NEAR)


def test_the_ground_truth_and_chance_are_lines_without_an_interval() -> None:
    _, figure = panel(MADE, "Accuracy over threshold, all")
    without = {name for name, trace in figure.traces.items() if "error_y" not in trace}
    assert (without, len(figure.traces)) == ({"oracle", "shuffled"}, 5)


def test_scores_by_distance_stand_at_their_bin_with_their_interval() -> None:
    found, figure = panel(MADE, "docked by distance, set")
    assert found.first
    assert list(figure.names("x").values()) == ["0-7\n(40)", "7-15\n(40)", "15-25\n(40)"]
    for name in ("rectangle-fit", "net", "other+icp"):
        trace = figure.traces[name]
        for at, value, span, label in zip(trace["x"], trace["y"], ends(trace, "y"), DISTANCES, strict=True):
            (item,) = rows_of(MADE, table="scores", group=label, estimator=name, metric="dock_0mm")
            assert figure.named("x", at).partition("\n")[0] == label.removesuffix(" m")
            assert (value, span) == (
                pytest.approx(100 * item.value, abs=NEAR),
                pytest.approx(percent(item)[1], abs=NEAR),
            )


def test_bins_are_in_the_order_of_their_numbers_and_one_more_grouping_has_a_chart_of_its_own() -> None:
    rng = np.random.default_rng(1)
    labels = ("7-15 m", "0-7 m", "25-35 m", "15-25 m")
    rows = [row(rng, "scores", "net", label, "found") for label in labels]
    rows += [row(rng, "scores", "net", f"{label}, at least 50 points", "found") for label in labels[:2]]
    made = result(rows)
    titles = [item.title for item in panels(made)]
    assert titles == ["found by distance", "found by distance, at least 50 points"]
    _, figure = panel(made, titles[0])
    assert [name.partition("\n")[0] for name in figure.names("x").values()] == ["0-7", "7-15", "15-25", "25-35"]
    trace = figure.traces["net"]
    by_bin = {figure.named("x", at).partition("\n")[0]: value for at, value in zip(trace["x"], trace["y"], strict=True)}
    assert by_bin == pytest.approx(
        {item.group.removesuffix(" m"): 100 * item.value for item in rows if "," not in item.group}, abs=NEAR
    )


def test_effects_are_plotted_with_their_interval_and_filled_only_where_it_leaves_zero_out() -> None:
    _, figure = panel(MADE, "docked gained or lost by light, against base")
    assert list(figure.names("y").values()) == ["dim", "night", "off"]
    assert set(figure.traces) == {"rectangle-fit", "net", "other+icp"}, (
        "the ground truth and chance have no place there"
    )
    hollow = []
    for name, trace in figure.traces.items():
        for place, value, span, symbol in zip(
            trace["y"], trace["x"], ends(trace, "x"), trace["marker"]["symbol"], strict=True
        ):
            label = f"light: {figure.named('y', place)}"
            (item,) = rows_of(MADE, table="effects", group=label, estimator=name, metric="dock_0mm")
            assert (value, span) == (
                pytest.approx(100 * item.value, abs=NEAR),
                pytest.approx(percent(item)[1], abs=NEAR),
            )
            low, high = item.interval
            hollow.append(symbol.endswith("-open"))
            assert hollow[-1] == (low <= 0.0 <= high)
    assert 0 < sum(hollow) < len(hollow) == 9


def test_one_level_alone_names_the_estimators() -> None:
    rng = np.random.default_rng(2)
    rows = [row(rng, "effects", name, "fusion", "dock_0mm", against="original") for name in ("early", "late")]
    _, figure = panel(result(rows), "docked gained or lost by fusion, against original")
    assert list(figure.names("y").values()) == ["early", "late"]
    for item in rows:
        trace = figure.traces[item.estimator]
        assert figure.named("y", trace["y"][0]) == item.estimator
        assert trace["x"] == pytest.approx([100 * item.value], abs=NEAR)


def test_boxes_are_the_quantiles() -> None:
    _, figure = panel(MADE, "How the error is spread, all")
    for name in ("net", "other+icp"):
        of_name, box = rows_of(MADE, table="spread", estimator=name), figure.traces[name]
        found = [box[part][0] for part in ("lowerfence", "q1", "median", "q3", "upperfence")]
        assert found == pytest.approx([100 * item.value for item in of_name], rel=1e-3)
        assert figure.named("y", box["y"][0]) == name
        interval = figure.traces[f"{name}: interval of the median"]["x"]
        assert interval == pytest.approx(percent(of_name[2])[1], rel=1e-3)


def test_what_is_below_a_thousandth_is_plotted_there() -> None:
    rows = [
        Row("spread", "oracle", "set", "all", item.metric, 0.0, (0.0, 0.1), 40, 4)
        for item in spread(np.random.default_rng(0), "oracle")
    ]
    _, figure = panel(result(rows), "How the error is spread, all")
    assert figure.traces["oracle"]["median"] == [0.1]


def test_score_against_samples_seen() -> None:
    rng = np.random.default_rng(4)
    facts = [EstimatorFacts("rectangle-fit", 0)]
    facts += [EstimatorFacts(f"{name}@{n}", 3, "", 32 * n) for name in ("early", "late") for n in (2000, 10000, 4000)]
    made = result([row(rng, "scores", item.name, "all", "dock_0mm") for item in facts], facts)
    _, figure = panel(made, "docked over samples seen")
    for name in ("early", "late"):
        trace = figure.traces[f"{name}@2000"]
        points = dict(zip(trace["x"], trace["y"], strict=True))
        wanted = {32 * n / 1000: 100 * rows_of(made, estimator=f"{name}@{n}")[0].value for n in (2000, 4000, 10000)}
        assert points == pytest.approx(wanted, abs=NEAR)
    level, value = figure.traces["rectangle-fit"], 100 * made.rows[0].value
    assert (level["x"], level["y"]) == ([64.0, 320.0], pytest.approx([value, value], abs=NEAR))


def test_margins_are_in_their_order() -> None:
    rng = np.random.default_rng(5)
    rows = [row(rng, "scores", "net", "all", f"dock_{mm}mm") for mm in (20, 0, 10)]
    _, figure = panel(result(rows), "Docked over the clearance to spare")
    trace = figure.traces["net"]
    assert list(figure.names("x").values()) == ["0", "10", "20"]
    found = {figure.named("x", at): value for at, value in zip(trace["x"], trace["y"], strict=True)}
    assert found == pytest.approx({item.metric[5:-2]: 100 * item.value for item in rows}, abs=NEAR)


def test_a_name_is_no_markup_of_the_chart() -> None:
    name = '<a href="javascript:x">net</a>'
    made = result([row(np.random.default_rng(6), "effects", name, "fusion", "dock_0mm", against="original")])
    (item,) = panels(made)
    assert "<a" not in str(item.plot())


def test_where_there_is_nothing_there_is_no_chart() -> None:
    assert list(panels(result([]))) == []
    only_bounds = everything(("oracle", "shuffled"))
    assert [item.title for item in panels(only_bounds)] == ["How the error is spread, all"]


def test_colours_and_marks_together_are_nobody_elses() -> None:
    facts = [EstimatorFacts(f"net {k}", 1) for k in range(40)] + [EstimatorFacts("rectangle-fit+lidar", 0)]
    looks = looks_of(facts)
    assert len({(look.color, look.mark) for look in looks.values()}) == 41
    assert looks["rectangle-fit+lidar"].kind == "baseline"
