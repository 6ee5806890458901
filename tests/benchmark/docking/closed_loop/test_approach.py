"""Approaches to a lone pallet: what must dock docks, what must fail fails, and the truck stops when it should."""

from dataclasses import replace

import numpy as np
import pytest

from tests.benchmark.docking.closed_loop.trucks import (
    CAMERA,
    NO_DRIFT,
    Until,
    approach,
    gt,
    start_at,
)
from tests.benchmark.docking.stations import at, station
from warehouse_sim.benchmark.docking.closed_loop import drive
from warehouse_sim.benchmark.docking.closed_loop.drive import ARRIVED, COLLIDED
from warehouse_sim.benchmark.docking.closed_loop.episode import Setting, episode, estimate_of
from warehouse_sim.benchmark.docking.closed_loop.settings import BASE, DRIFTS, DRIVE
from warehouse_sim.evaluation.docking.fork import docking_errors
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene.viewpoints.mountings import FORKLIFT

SETTING = Setting("alone", 0, CAMERA)
PLACE = station(300.0, pose=at(0.7, -1.2, 0.072, 2.1))
GRID = [(back, fraction, off) for back in (4.0, 5.5, 7.0) for fraction in (-0.15, 0.0, 0.15) for off in (-10, 0, 10)]
"""From the face (m), beside its axis as a fraction of the way to go, and off the line of sight (deg)."""


def start_of(face: str, back: float, fraction: float, off: float):
    aside = fraction * (back - FORKLIFT.tip)
    return start_at(PLACE, face, back, aside, np.deg2rad(off) - np.arctan2(aside, back))


def errors_of(start, found):
    T = estimate_of(found.T_world_dock, start.pallet.T_world_object, start.face.T_object_dock)
    return docking_errors(T[None], start.face)


@pytest.mark.parametrize("face", ["-x", "+y"])
def test_true_poses_lead_to_the_entry_from_everywhere(face: str) -> None:
    for back, fraction, off in GRID:
        start = start_of(face, back, fraction, off)
        found = approach(start, gt(start))
        assert found.ended == ARRIVED, (back, fraction, off)
        errors = errors_of(start, found)
        far = back > 5.0
        assert abs(errors.lateral[0]) < (0.003 if far else 0.02), (back, fraction, off)
        assert abs(errors.yaw[0]) < np.deg2rad(0.15 if far else 0.8), (back, fraction, off)
        assert abs(errors.depth[0]) < 0.002
        assert abs(errors.vertical[0]) < 1e-6


@pytest.mark.parametrize("back", [4.0, 7.0])
@pytest.mark.parametrize("drift", ["none", "usual"])
def test_the_ground_truth_docks(back: float, drift: str) -> None:
    for fraction, off in [(-0.15, 8.0), (0.12, -10.0)]:
        start = start_of("-x", back, fraction, off)
        row, _ = episode(SETTING, start, replace(BASE, drift=drift), "oracle", gt(start))
        assert row["outcome"] == "docked"
        assert row["swept"]["docks"]


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_an_estimate_that_is_always_aside_does_not_dock(side: float) -> None:
    start = start_at(PLACE, "-x", 5.0, 0.3, 0.1)
    aside = make_transform(None, np.array([0.0, 0.2 * side, 0.0]))
    row, found = episode(SETTING, start, NO_DRIFT, "wrong", gt(start, aside))
    assert found.ended == ARRIVED  # the truck cannot know
    assert abs(row["errors"]["lateral"]) == pytest.approx(0.2, abs=0.012)
    assert row["outcome"] in ("struck", "pushed")
    assert not row["swept"]["docks"]


def test_a_truck_that_sees_nothing_stays_and_stops() -> None:
    start = start_at(PLACE, "-x", 5.0, 0.3, 0.1)
    found = approach(start, Until(gt(start)))
    assert found.ended == "no estimate"
    assert found.distance == 0.0
    assert found.images == DRIVE.patience


def test_a_truck_that_trusts_nothing_stops_too() -> None:
    start = start_at(PLACE, "-x", 5.0, 0.3, 0.1)
    assert approach(start, Until(gt(start), 0, score=0.19)).ended == "unsure"
    assert approach(start, Until(gt(start), 0, score=0.21)).ended == ARRIVED


def test_a_truck_that_loses_its_pallet_stops_on_the_way_but_not_right_before_it() -> None:
    start = start_at(PLACE, "-x", 6.5, 0.3, 0.1)
    lost = approach(start, Until(gt(start), 3))
    assert lost.ended == "no estimate"
    assert 0.3 < lost.distance < 4.0
    whole = approach(start, gt(start))
    near = approach(start, Until(gt(start), whole.images - 3))
    assert near.ended == ARRIVED


def test_a_delay_changes_nothing_for_a_truck_that_stands_still_or_knows_how_it_moved() -> None:
    start = start_at(PLACE, "-x", 5.5, 0.4, 0.15)
    prompt, late, careless = (
        approach(start, gt(start), replace(NO_DRIFT, delay=delay, compensated=kept))
        for delay, kept in ((0.0, True), (0.5, True), (0.5, False))
    )
    # Before its first estimate the truck stands.
    np.testing.assert_allclose(late.believed[0], prompt.believed[0], atol=1e-9)
    np.testing.assert_allclose(careless.believed[0], prompt.believed[0], atol=1e-9)
    for entry in late.believed:
        np.testing.assert_allclose(entry, prompt.believed[0], atol=1e-9)
    assert late.time > prompt.time
    assert late.corrections == prompt.corrections == 0
    # One that forgets that it drove on believes the pallet farther away, by up to half a second's way.
    farther = [float((entry[:2, 3] - prompt.believed[0][:2, 3]) @ entry[:2, 0]) for entry in careless.believed]
    assert 0.02 < max(farther) <= 0.55 * DRIVE.speed


def test_the_open_loop_looks_once() -> None:
    start = start_at(PLACE, "-x", 5.5, 0.4, 0.15)
    found = approach(start, gt(start), replace(NO_DRIFT, is_open=True))
    assert (found.ended, found.images, found.corrections) == (ARRIVED, 1, 0)


def test_drift_moves_the_open_loop_by_what_odometry_is_wrong_and_not_the_closed_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(drive, "DRIVE", replace(DRIVE, max_lateral=1.0, max_yaw=1.0))
    start = start_at(PLACE, "-x", 6.5, 0.0, 0.0)
    far, near = [], []
    for seed in range(12):
        for is_open, errors in ((True, far), (False, near)):
            condition = replace(NO_DRIFT, drift="strong", is_open=is_open)
            found = approach(start, gt(start), condition, seed=seed)
            errors.append(float(errors_of(start, found).lateral[0]))
    # A steady turn of k a metre leads k s^2 / 2 aside after s = 4.78 m, and further over the 1.72 m to the entry.
    expected = np.deg2rad(DRIFTS["strong"].turn_deg) * 4.78 * (4.78 / 2.0 + 1.72)
    assert 0.4 * expected < np.std(far) < 2.0 * expected
    assert np.std(near) < 0.35 * np.std(far)


def test_a_pose_that_is_turned_by_a_quarter_is_out_of_reach_of_a_pallet_with_two_sides() -> None:
    start = start_at(station(pallet="gma_48x40"), "-x", 5.0, 0.0, 0.0)
    quarter = make_transform(rotation_z(np.deg2rad(89.0)))
    found = approach(start, gt(start, quarter), sides=("-x", "+x"))
    assert found.ended == "out of reach"
    assert found.distance == 0.0
    assert approach(start, gt(start), sides=("-x", "+x")).ended == ARRIVED


def test_a_truck_that_touches_something_ends_there() -> None:
    start = start_at(PLACE, "-x", 5.0, 0.3, 0.0)
    first = start.pose
    found = approach(start, gt(start), touches=lambda pose: np.hypot(pose.x - first.x, pose.y - first.y) > 1.0)
    assert found.ended == COLLIDED
    assert found.distance == pytest.approx(1.0, abs=0.15)
    assert found.T_world_dock is None


@pytest.mark.parametrize("away", [0.25, 0.6])
def test_one_wrong_pose_on_the_way_is_outvoted(away: float) -> None:
    start = start_at(PLACE, "-x", 6.0, 0.2, 0.05)
    aside = gt(start, make_transform(rotation_z(0.5), np.array([0.0, away, 0.0])))
    right = gt(start)

    class Once:
        min_score = 0.0

        def __call__(self, glance):
            return (aside if glance.index in (6, 11) else right)(glance)

    found = approach(start, Once())
    assert found.ended == ARRIVED
    assert found.corrections == 0
    assert abs(errors_of(start, found).lateral[0]) < 0.003
