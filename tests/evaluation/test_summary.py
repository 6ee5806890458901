import numpy as np
import pytest

from tests.evaluation.tables import missed, row, table, without_pockets
from warehouse_sim.evaluation.summary import (
    Summary,
    accuracy_curve,
    median_values,
    pass_values,
    posecnn_auc,
    split_groups,
    summarise,
)


def fractions(*rows):
    return {name: float(np.nanmean(values)) for name, values in pass_values(table(*rows)).items()}


def test_accuracy_is_the_share_below_a_part_of_the_diameter_and_misses_count():
    got = fractions(row(add=0.028, diameter=1.449), row(add=0.030), row(add=0.08), missed())
    assert (got["add_2pct"], got["add_5pct"], got["add_10pct"]) == (0.25, 0.5, 0.75)


def test_every_share_is_one_for_perfect_rows_and_zero_for_misses():
    assert set(fractions(row(), row()).values()) == {1.0}
    assert set(fractions(missed(), missed()).values()) == {0.0}


def test_docking_margins_ask_for_clearance_on_both_axes():
    rows = [row(slack_lateral=0.064, slack_vertical=0.015), row(slack_lateral=0.005), row(slack_lateral=-0.001)]
    got = fractions(*rows)
    assert (got["dock_0mm"], got["dock_10mm"], got["dock_20mm"]) == pytest.approx((2 / 3, 1 / 3, 0.0))


def test_docking_is_left_out_for_objects_without_pockets():
    values = pass_values(table(without_pockets(), row()))
    for name in ("dock_0mm", "dock_gate_20mm_2.9deg", "dock_gate_50mm_3deg"):
        assert np.isnan(values[name]).tolist() == [True, False]
    assert not np.isnan(values["mssd_5cm"]).any()


@pytest.mark.parametrize(
    ("errors", "tight", "loose"),
    [
        ({"lateral": -0.019, "yaw": 2.8}, 1.0, 1.0),
        ({"lateral": 0.021, "yaw": 0.0}, 0.0, 1.0),
        ({"lateral": 0.0, "yaw": -2.95}, 0.0, 1.0),
        ({"lateral": 0.0, "yaw": 3.05}, 0.0, 0.0),
        ({"lateral": 0.0, "pitch": 1.1}, 1.0, 0.0),
        ({"lateral": 0.051}, 0.0, 0.0),
    ],
)
def test_gates_of_the_literature(errors, tight, loose):
    angles = {name: np.deg2rad(value) for name, value in errors.items() if name != "lateral"}
    got = fractions(row(**(errors | angles)))
    assert (got["dock_gate_20mm_2.9deg"], got["dock_gate_50mm_3deg"]) == (tight, loose)


def test_posecnn_area_exceeds_the_mean_form_by_the_largest_error_fraction():
    errors = np.array([0.01, 0.03, 0.02, 0.2, np.inf])
    mean_form = fractions(*[row(add=error) for error in errors])["auc_add_10cm"]
    assert mean_form == pytest.approx((0.9 + 0.7 + 0.8) / 5)
    assert posecnn_auc(errors) == pytest.approx(mean_form + 0.03 / (0.1 * 5))
    assert posecnn_auc(np.zeros(3)) == 1.0
    assert posecnn_auc(np.array([0.11, np.inf])) == 0.0


def test_medians_count_misses_as_infinite():
    assert median_values(table(row(add=0.1), row(add=0.3), missed()))["median_add"] == 0.3
    assert median_values(table(row(add=0.1), row(add=0.3)))["median_add"] == pytest.approx(0.2)
    assert median_values(table(row(), missed(), missed()))["median_add"] == np.inf
    assert median_values(table(row(), missed()))["median_add"] == np.inf
    assert median_values(table(row(yaw=-0.1)))["median_yaw_deg"] == pytest.approx(np.rad2deg(0.1))
    assert median_values(table(row(pitch=-0.2)))["median_pitch_deg"] == pytest.approx(np.rad2deg(0.2))


def test_accuracy_curve_rises_to_the_found_fraction():
    curve = accuracy_curve(np.array([0.01, 0.02, np.inf, 0.05]), np.array([0.0, 0.015, 0.05, 1.0]))
    assert curve.tolist() == [0.0, 0.25, 0.5, 0.75]


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


def test_bins_by_light_leave_out_what_is_not_known_and_objects_go_by_name():
    rows = [row(illuminance=lux) for lux in (10.0, 99.9, 100.0, 5000.0, np.nan)] + [row(object_name="gma")]
    groups = split_groups(table(*rows))
    assert {label: int(rows.sum()) for label, rows in groups["illuminance"]} == {
        "0-50 lx": 1, "50-100 lx": 1, "100-200 lx": 2, "200-400 lx": 0, "400-800 lx": 0, "over 800 lx": 1,
    }  # fmt: skip
    assert {label: int(rows.sum()) for label, rows in groups["object"]} == {"epal1": 5, "gma": 1}
