import math

import numpy as np
import pytest

from tests.evaluation.tables import missed, row, table, without_pockets
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation.error_table import read_table, write_table
from warehouse_sim.evaluation.report.numbers import (
    NOTHING,
    centimetres,
    counted,
    degrees,
    fraction_cell,
    percent,
    signed,
)
from warehouse_sim.evaluation.report.score_sections import choose_cases
from warehouse_sim.evaluation.summary import summarise


def test_a_table_survives_its_file_with_infinities_and_nan(tmp_path):
    before = table(row(add=0.0123456, face="+y"), missed(scene_id=7), without_pockets())
    write_table(before, tmp_path / "errors.csv")
    after = read_table(tmp_path / "errors.csv")
    for name, column in before.columns().items():
        assert after.columns()[name].dtype.kind == column.dtype.kind, name
        if column.dtype.kind == "f":
            np.testing.assert_allclose(after.columns()[name], column, rtol=1e-6)
        else:
            assert after.columns()[name].tolist() == column.tolist()


def test_select_found_and_dockable():
    both = table(row(), missed(), without_pockets())
    assert both.found.tolist() == [True, False, True]
    assert both.dockable.tolist() == [True, True, False]
    assert len(both.select(both.found)) == 2
    assert both.slack[:2].tolist() == [0.030, -np.inf]


def test_what_stops_at_the_wrong_depth_has_no_clearance_and_does_not_dock():
    rows = table(row(), row(slack_depth=-0.001), row(slack_depth=-1e-10), row(slack_vertical=-0.001), without_pockets())
    assert rows.slack[:4].tolist() == [0.030, -np.inf, 0.030, -0.001]
    assert rows.docks().tolist() == [True, False, True, False, False]
    assert rows.docks(0.031).tolist() == [False] * 5


@pytest.mark.parametrize(
    "content",
    ["scene_id,image_id\n0,0\n", None, "scene_id\nx\n", "scene_id\n" + "9" * 30, "scene_id\n\0", "a" * 200_000],
)
def test_what_is_no_table_is_rejected_with_its_path(tmp_path, content):
    path = tmp_path / "errors.csv"
    if content is not None:
        path.write_text(content)
    with pytest.raises(EvaluationError, match=r"errors\.csv: is not a table"):
        read_table(path)


@pytest.mark.parametrize(
    ("value", "text"),
    [(1.0, "100.0"), (0.9999, "99.9"), (0.5, "50.0"), (0.0, "0.0"), (math.nan, NOTHING), (None, NOTHING)],
)
def test_only_all_is_written_as_all(value, text):
    assert percent(value) == text


def test_lengths_and_angles_without_a_value_are_left_empty():
    assert (centimetres(0.01234), centimetres(math.inf), centimetres(None)) == ("1.23", NOTHING, NOTHING)
    assert (degrees(1.005), degrees(math.nan)) == ("1.00", NOTHING)


def test_signs_are_kept_unless_the_number_rounds_to_zero():
    assert [signed(value) for value in (0.26, -0.26, -0.04, 0.0)] == ["+0.3", "\N{MINUS SIGN}0.3", "0.0", "0.0"]


def test_counts_agree_with_their_noun():
    assert [counted(n, "scene") for n in (0, 1, 1200)] == ["0 scenes", "1 scene", "1,200 scenes"]


def test_a_share_cell_has_text_interval_and_bar():
    summary = summarise("all", table(row(), row(add=1.0)))
    cell = fraction_cell(summary, "add_5pct")
    assert (cell["text"], cell["value"]) == ("50.0", 50.0)
    assert 0.0 <= cell["low"] < 50.0 < cell["high"] <= 100.0
    assert fraction_cell(summary, "no_such_metric") == {"text": NOTHING, "interval": "", "value": None}


def test_best_middle_worst_and_missed_are_told_apart():
    rows = [row(add=add) for add in [0.05, 0.01, 0.09, 0.02, 0.08, 0.03, 0.07]]
    rows += [missed(visible_fraction=0.2), missed(visible_fraction=0.9)]
    groups = {group.title: group.rows for group in choose_cases(table(*rows), 2)}
    assert groups == {"Best": (1, 3), "Median": (5, 0), "Worst": (2, 4), "Missed": (8, 7)}


def test_no_row_is_shown_twice_however_few_there_are():
    for count in range(1, 12):
        rows = table(*[row(add=0.01 * i) for i in range(count)])
        shown = [index for group in choose_cases(rows, 3) for index in group.rows]
        assert len(shown) == len(set(shown)) > 0


def test_only_misses_leave_only_misses():
    groups = choose_cases(table(missed(), missed()), 3)
    assert [group.title for group in groups] == ["Missed"]
    assert np.array(groups[0].rows).tolist() == [0, 1]
