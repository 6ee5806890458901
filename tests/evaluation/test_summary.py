import numpy as np
import pytest

from tests.evaluation.tables import missed, row, table, without_pockets
from warehouse_sim.evaluation.summary import Summary, split_groups, summarise


def test_a_summary_has_shares_with_intervals_around_them():
    rows = [row(scene_id=i // 5, add=0.01 if i % 4 else 0.5) for i in range(40)] + [missed(scene_id=9)]
    got = summarise("all", table(*rows))
    assert (got.gt_count, got.found_count, got.dockable_count) == (41, 40, 41)
    assert got.metrics["add_5pct"] == pytest.approx(30 / 41)
    low, high = got.intervals["add_5pct"]
    assert 0.5 < low < 30 / 41 < high < 0.9


def test_an_empty_group_has_no_numbers_and_no_intervals():
    empty = table(row()).select(np.array([False]))
    got = summarise("over 12 m", empty)
    assert (got.gt_count, got.intervals) == (0, {})
    assert all(np.isnan(value) for value in got.metrics.values())


def test_a_summary_survives_json_with_null_for_what_is_not_finite():
    got = summarise("all", table(missed(), missed(), without_pockets()))
    plain = got.row()
    assert plain["metrics"]["median_add"] is None
    again = Summary.read(plain, "here")
    assert again.metrics["add_2pct"] == pytest.approx(1 / 3, abs=1e-6)
    assert np.isnan(again.metrics["median_add"])
    assert again.row() == plain


def test_bins_hold_every_ground_truth_once_and_touch_without_overlap():
    rows = [
        row(distance=d, visible_fraction=v) for d, v in [(0.5, 0.1), (2.0, 0.3), (7.99, 0.95), (12.0, 1.0), (40, 0.5)]
    ]
    groups = split_groups(table(*rows))
    assert [label for label, _ in groups["distance"]] == ["0-2 m", "2-4 m", "4-6 m", "6-8 m", "8-12 m", "over 12 m"]
    assert np.array([rows for _, rows in groups["distance"]]).astype(int).tolist() == [
        [1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 1, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 1, 1],
    ]  # fmt: skip
    assert np.array([rows for _, rows in groups["visible_fraction"]]).sum(axis=0).tolist() == [1] * 5
    assert [label for label, _ in groups["visible_fraction"]][-1] == "0.9-1"


def test_classes_are_groups_of_their_own():
    groups = split_groups(table(row(class_name="pallet"), row(class_name="carton"), row()))
    assert [(label, int(rows.sum())) for label, rows in groups["class"]] == [("carton", 1), ("pallet", 2)]


def test_the_same_rows_give_the_same_intervals():
    rows = table(*[row(scene_id=i // 4, add=0.02 * i) for i in range(24)])
    assert summarise("a", rows).intervals == summarise("a", rows).intervals


def test_bins_by_light_leave_out_what_is_not_known_and_objects_go_by_name():
    rows = [row(illuminance=lux) for lux in (10.0, 99.9, 100.0, 5000.0, np.nan)] + [row(object_name="gma")]
    groups = split_groups(table(*rows))
    assert {label: int(rows.sum()) for label, rows in groups["illuminance"]} == {
        "0-50 lx": 1, "50-100 lx": 1, "100-200 lx": 2, "200-400 lx": 0, "400-800 lx": 0, "over 800 lx": 1,
    }  # fmt: skip
    assert {label: int(rows.sum()) for label, rows in groups["object"]} == {"epal1": 5, "gma": 1}
