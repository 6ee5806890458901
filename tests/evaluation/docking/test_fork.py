import numpy as np
import pytest

from tests.evaluation.pallet import SIZE, nudge, pockets, seen_from
from warehouse_sim.evaluation.docking.fork import (
    approached_face,
    docking_errors,
    docking_faces,
)

FACES = docking_faces(SIZE, pockets())
SHORT_SIDE = next(face for face in FACES if face.name == "-x")


def at_entry(face, **motion):
    """An estimate that is off by a motion in the docking frame of ``face``."""
    T_dock = face.T_object_dock
    return (T_dock @ nudge(**motion) @ np.linalg.inv(T_dock))[None]


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


def test_an_object_without_pockets_has_four_sides_that_look_outwards():
    sides = {face.name: face for face in docking_faces(SIZE, ())}
    assert sides["+y"].T_object_dock[:3, 3] == pytest.approx([0, 0.4, 0])
    assert sides["+y"].T_object_dock[:3, 0] == pytest.approx([0, -1, 0])
    assert sides["-x"].T_object_dock[:3, 3] == pytest.approx([-0.6, 0, 0])
    assert {name: face.depth for name, face in sides.items()} == pytest.approx(
        {"-x": 1.2, "+x": 1.2, "-y": 0.8, "+y": 0.8}
    )
    assert all(face.pockets == () for face in sides.values())
