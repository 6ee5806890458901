"""The headline of several layouts is each estimator's worst, and a row of faces is a line that people count by."""

from warehouse_sim.benchmark.report.markdown import face_lines
from warehouse_sim.benchmark.rows.row import WORST, Row
from warehouse_sim.benchmark.rows.scores import worst_rows


def row(estimator: str, condition: str, value: float, metric: str = "dock_0mm", group: str = "all") -> Row:
    return Row("scores", estimator, condition, group, metric, value, (0.0, 1.0), 10, 2)


def test_everybody_is_headed_by_the_layout_where_it_docks_least() -> None:
    rows = [
        *(row("a", "rack", 0.5), row("a", "rack", 0.9, "found"), row("a", "dock", 0.3), row("a", "dock", 0.8, "found")),
        *(row("b", "rack", 0.2), row("b", "dock", 0.7), row("b", "dock", 0.1, group="stacked")),
        row("c", "rack", 0.1),
    ]
    found = {(item.estimator, item.metric): item.value for item in worst_rows(rows, ["rack", "dock"])}
    assert found == {("a", "dock_0mm"): 0.3, ("a", "found"): 0.8, ("b", "dock_0mm"): 0.2}
    assert {item.condition for item in worst_rows(rows, ["rack", "dock"])} == {WORST}


def test_recorded_faces_are_counted_by_method_and_condition() -> None:
    rows = [Row("faces", "front-fit", "masks: gt, gravity: none", "fronts", "docked", 24 / 26, (0.7, 1.0), 26, 5)]
    assert list(face_lines(rows)) == ["front-fit, masks: gt, gravity: none  24 of 26"]
    other = Row("faces", "oracle", "masks: gt, gravity: none", "more", "docked", 1.0, (0.5, 1.0), 3, 1)
    assert list(face_lines([*rows, other]))[1] == "oracle, masks: gt, gravity: none, more  3 of 3"
