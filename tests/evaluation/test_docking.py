import numpy as np
import pytest

from tests.evaluation.pallet import SIZE, nudge, pockets, seen_from
from warehouse_sim.evaluation.docking import (
    ForkConfig,
    approached_face,
    docking_errors,
    docking_faces,
    docking_slack,
    failure_axes,
    insertion_depth,
)

FORK = ForkConfig()
FACES = docking_faces(SIZE, pockets())
SHORT_SIDE = next(face for face in FACES if face.name == "-x")
LONG_SIDE = next(face for face in FACES if face.name == "+y")


def at_entry(face, **motion):
    """An estimate that is off by a motion in the docking frame of ``face``."""
    T_dock = face.T_object_dock
    return (T_dock @ nudge(**motion) @ np.linalg.inv(T_dock))[None]


def slack(face, **motion):
    lateral, vertical = docking_slack(at_entry(face, **motion), face, FORK)
    return lateral[0], vertical[0]


def test_a_perfect_estimate_leaves_the_room_of_the_epal_drawing():
    assert slack(SHORT_SIDE) == pytest.approx((0.06375, 0.030))
    assert slack(LONG_SIDE) == pytest.approx((0.14125, 0.030))


@pytest.mark.parametrize(("degrees", "limit_mm"), [(0, 64), (1, 44), (2, 24), (3, 3.5)])
def test_lateral_limit_at_the_entry_shrinks_with_yaw_as_published(degrees, limit_mm):
    # |e_y| + 1.15 tan(yaw) <= 63.75 mm about the entry face; the tine's own width moves it by 50 (1 - cos) mm.
    yaw = np.deg2rad(degrees)
    assert 1000 * slack(SHORT_SIDE, yaw=yaw)[0] == pytest.approx(limit_mm, abs=0.6)
    assert slack(SHORT_SIDE, yaw=yaw, y=(limit_mm - 1) / 1000)[0] > 0
    assert slack(SHORT_SIDE, yaw=yaw, y=(limit_mm + 1) / 1000)[0] < 0


def test_each_offset_uses_up_its_own_slack_on_every_face():
    for face in FACES:
        beside, above = slack(face)
        assert slack(face, y=0.02) == pytest.approx((beside - 0.02, above))
        assert slack(face, y=-0.02) == pytest.approx((beside - 0.02, above))
        assert slack(face, z=0.02) == pytest.approx((beside, above - 0.02))
        assert slack(face, x=0.3) == pytest.approx((beside, above))


def test_the_pocket_limits_how_deep_a_tine_enters():
    assert insertion_depth(SHORT_SIDE.pockets[0], FORK) == 1.15
    assert insertion_depth(LONG_SIDE.pockets[0], FORK) == 0.8
    pitch = np.deg2rad(1.0)
    # The lower tip corner rises by L sin(pitch) and the tine's half thickness counts as 20 cos(pitch) mm.
    expected = 0.050 - 0.8 * np.sin(pitch) - 0.02 * np.cos(pitch)
    assert slack(LONG_SIDE, pitch=-pitch)[1] == pytest.approx(expected)


def test_a_pallet_taken_for_its_quarter_turn_cannot_be_docked():
    quarter = nudge(yaw=np.pi / 2)[None]
    assert min(docking_slack(quarter, SHORT_SIDE, FORK)[0]) < -0.1


@pytest.mark.parametrize(
    ("yaw", "name"), [(0.0, "-x"), (np.pi, "+x"), (np.pi / 2, "+y"), (-np.pi / 2, "-y"), (0.6, "-x")]
)
def test_the_approached_face_is_the_one_towards_the_camera(yaw, name):
    index = approached_face(seen_from(4.0, yaw)[None], FACES)[0]
    assert FACES[index].name == name


def test_docking_errors_are_signed_as_a_driver_sees_them():
    motion = {"x": 0.01, "y": 0.02, "z": -0.03, "yaw": 0.04}
    for face in FACES:
        errors = docking_errors(at_entry(face, **motion), face)
        assert (errors.depth[0], errors.lateral[0], errors.vertical[0], errors.yaw[0]) == pytest.approx(
            (0.01, 0.02, -0.03, 0.04)
        )
    assert docking_errors(at_entry(SHORT_SIDE, pitch=-0.05), SHORT_SIDE).pitch[0] == pytest.approx(0.05)
    assert docking_errors(at_entry(SHORT_SIDE, roll=0.05), SHORT_SIDE).roll[0] == pytest.approx(0.05)


def test_yaw_about_the_pallet_centre_is_a_lateral_error_at_the_entry():
    errors = docking_errors(nudge(yaw=np.deg2rad(3.0))[None], SHORT_SIDE)
    assert errors.lateral[0] == pytest.approx(-0.6 * np.sin(np.deg2rad(3.0)))


@pytest.mark.parametrize(
    ("motion", "axis"),
    [
        ({"y": 0.08}, "lateral"),
        ({"z": -0.04}, "vertical"),
        ({"yaw": 0.08}, "yaw"),
        ({"pitch": 0.05, "y": 0.01}, "pitch"),
        ({"roll": 0.3}, "roll"),
    ],
)
def test_the_failure_axis_is_the_error_that_uses_up_most_room(motion, axis):
    assert min(slack(SHORT_SIDE, **motion)) < 0
    T = at_entry(SHORT_SIDE, **motion)
    assert failure_axes(docking_errors(T, SHORT_SIDE), SHORT_SIDE, FORK) == [axis]


def test_an_object_without_pockets_has_four_sides_that_look_outwards():
    sides = {face.name: face for face in docking_faces(SIZE, ())}
    assert sides["+y"].T_object_dock[:3, 3] == pytest.approx([0, 0.4, 0])
    assert sides["+y"].T_object_dock[:3, 0] == pytest.approx([0, -1, 0])
    assert sides["-x"].T_object_dock[:3, 3] == pytest.approx([-0.6, 0, 0])
    assert all(face.pockets == () for face in sides.values())
