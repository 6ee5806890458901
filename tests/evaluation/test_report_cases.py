import numpy as np

from tests.evaluation.tables import missed, row, table
from warehouse_sim.evaluation.report.score_sections import choose_cases


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
