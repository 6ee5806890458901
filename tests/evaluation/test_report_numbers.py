import math

import pytest

from tests.evaluation.tables import row, table
from warehouse_sim.evaluation.report.numbers import (
    NOTHING,
    centimetres,
    counted,
    degrees,
    fraction_cell,
    percent,
    signed,
)
from warehouse_sim.evaluation.summary import summarise


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
