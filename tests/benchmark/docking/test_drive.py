"""The simulated truck against what can be said with a pencil."""

from dataclasses import replace

import numpy as np
import pytest

from tests.benchmark.docking.stations import at, estimate, station
from warehouse_sim.benchmark.docking import drive as driving
from warehouse_sim.benchmark.docking.drive import Docking, dock
from warehouse_sim.benchmark.docking.truck import TRUCK
from warehouse_sim.evaluation.docking.fork import HEEL_GAP, TINE_THICKNESS
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_z

PATIENT = replace(TRUCK, max_force=1e9, max_push=10.0)
"""Goes on whatever it strikes."""


def drive(place, face: str, **errors: float) -> Docking:
    return dock(place, place.face(face), estimate(place, face, **errors), np.random.default_rng(0))


@pytest.mark.parametrize("face", ["-x", "+x", "-y", "+y"])
@pytest.mark.parametrize("load", [0.0, 400.0])
def test_the_ground_truth_docks(face: str, load: float) -> None:
    found = drive(station(load, pose=at(0.4, -0.3, 0.072, 0.7)), face)
    assert found.outcome == "docked"
    assert found.inside == pytest.approx(1.10, abs=0.002)
    assert (found.force, found.push) == (0.0, pytest.approx(0.0, abs=1e-4))


@pytest.mark.parametrize("load", [0.0, 400.0])
@pytest.mark.parametrize("face", ["-x", "+y"])
def test_a_heel_that_passes_the_face_pushes(face: str, load: float) -> None:
    assert drive(station(load), face, depth=0.045).docked
    found = drive(station(load), face, depth=0.2)
    assert found.outcome in ("pushed", "struck")
    assert found.by.startswith(("shank", "backrest"))


def test_the_push_is_what_the_estimate_is_too_deep_by(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(driving, "TRUCK", PATIENT)
    found = drive(station(), "-x", depth=0.2)
    assert found.push == pytest.approx(0.2 - HEEL_GAP, abs=0.005)


def test_the_force_of_a_slow_push_is_the_friction_of_the_floor(monkeypatch: pytest.MonkeyPatch) -> None:
    place = station(load_kg=100.0)
    mass = 100.0 + place.scene.model_of(place.pallet).mass
    monkeypatch.setattr(driving, "TRUCK", replace(PATIENT, speed=0.05, force_time=2.0))  # 3 s of pushing
    found = drive(place, "-x", depth=0.2)
    # The heels hold the pallet down by their own friction, which the floor answers with more: at most 1 / (1 - mu mu').
    weight, floor, steel = mass * 9.81, TRUCK.friction_floor, TRUCK.friction_steel
    most = floor * weight / (1.0 - floor * steel) * np.hypot(1.0, steel)
    assert floor * weight < found.force < most


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(
    ("face", "error", "clearance"),
    [
        # Half of what the opening is wider or higher than a tine: EPAL's 227.5 x 100 and 382.5 x 78 mm.
        ("-x", "lateral", 0.06375),
        ("+y", "lateral", 0.14125),
    ],
)
def test_tines_that_pass_beside_the_blocks_dock_and_others_strike_them(face, error, clearance, side) -> None:
    play = TRUCK.side_play + 0.001
    assert drive(station(300.0), face, **{error: side * (clearance - play)}).docked
    found = drive(station(300.0), face, **{error: side * (clearance + play + 0.002)})
    assert not found.docked
    assert found.by.endswith("block")


def test_tines_too_high_strike_the_deck_and_too_low_the_base_boards() -> None:
    # Over the base boards of the long side lie 78 mm up to the stringer boards' upper end; a tine is 40 mm.
    high, low = drive(station(300.0), "+y", vertical=0.045), drive(station(300.0), "+y", vertical=-0.045)
    assert not high.docked
    assert not low.docked
    assert low.by.endswith("base")


def test_yaw_uses_up_the_clearance_beside_the_tines() -> None:
    # About the entry the tips move by 1.1 m x yaw: 63.75 mm at 3.3 degrees.
    assert drive(station(300.0), "-x", yaw=np.deg2rad(3.1)).docked
    assert not drive(station(300.0), "-x", yaw=np.deg2rad(4.0)).docked


def test_a_pallet_is_held_when_the_tips_reach_beyond_its_middle() -> None:
    # Statics: the tips must pass the centre of mass, 0.6 m behind the face.
    assert drive(station(200.0), "-x", depth=-0.40).docked  # 0.70 m inside
    assert drive(station(200.0), "-x", depth=-0.60).outcome in ("fell", "not lifted")  # 0.50 m


def test_what_a_level_truck_cannot_drive_to_is_rejected() -> None:
    place = station()
    face = place.face("-x")
    over, around = make_transform(rotation_x(np.pi)), make_transform(rotation_z(np.pi))
    evaluated = [dock(place, face, T, np.random.default_rng(0)) for T in (over, around)]
    assert [(found.outcome, found.by) for found in evaluated] == [("rejected", "upside down"), ("rejected", "reversed")]


@pytest.mark.parametrize("pitch_deg", [2.0, 4.0])
def test_the_lift_stops_over_the_floor_where_an_estimate_points_up(pitch_deg: float) -> None:
    """The axis of such an estimate begins below the floor: 1.2 m before the face by 4 or 8 cm."""
    place, lowest = station(200.0), []

    def watch(model, data) -> None:
        at = data.body("forks")
        half = TINE_THICKNESS / 2.0
        for x in (-2 * half, 0.0):
            lowest.append(float((at.xpos + at.xmat.reshape(3, 3) @ [x, 0.0, -half])[2]))

    T = estimate(place, "-x", pitch=np.deg2rad(pitch_deg))
    found = dock(place, place.face("-x"), T, np.random.default_rng(0), watch)
    assert "floor" not in found.by
    assert not found.docked  # 1.1 m x 2 deg = 38 mm is more than the clearance above
    assert min(lowest) > 0.0


def test_the_same_question_has_the_same_answer() -> None:
    evaluated = [drive(station(200.0), "-x", lateral=0.06, yaw=0.01) for _ in range(2)]
    assert evaluated[0] == evaluated[1]
