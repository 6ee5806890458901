"""The fork's way into a pallet, judged by linear programming and by a fork of points that is driven step by step."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from tests.evaluation.pallet import SIZE, nudge, pockets, random_motion
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.pallets import PALLETS
from warehouse_sim.evaluation.docking.fork import DockingFace, docking_errors, docking_faces
from warehouse_sim.evaluation.docking.insertion import docking_slack, failure_axes, insertion_depth

TINE = (0.100, 0.040)
HEEL, TIP = -0.05, 1.10
"""Where the ends of the tines stop behind the estimated face (m)."""
FACES = docking_faces(SIZE, pockets())
SHORT_SIDE = next(face for face in FACES if face.name == "-x")
LONG_SIDE = next(face for face in FACES if face.name == "+y")
EVERY_FACE = {
    f"{name} {face.name}": (face, catalog_object(name).size["xy".index(face.name[1])])
    for name in sorted(PALLETS)
    for face in docking_faces(catalog_object(name).size, catalog_object(name).pockets)
}
"""Every side of every pallet of the catalog, with the length D of the pallet along the forks."""


def at_entry(face, **motion):
    """An estimate that is off by a motion in the docking frame of ``face``."""
    return moved(face, nudge(**motion))


def moved(face, motion):
    T_dock = face.T_object_dock
    return (T_dock @ motion @ np.linalg.inv(T_dock))[None]


def docks(face, T):
    slack = docking_slack(T, face)
    return bool(min(slack.lateral[0], slack.vertical[0], slack.depth[0]) >= 0.0)


def walls(face, **motion):
    slack = docking_slack(at_entry(face, **motion), face)
    return slack.lateral[0], slack.vertical[0]


def failure(face, T):
    return failure_axes(docking_errors(T, face), docking_slack(T, face), face)[0]


def clearance_by_programming(T_pocket_tine, size):
    """Least clearance in y and z of what is in the pocket and in the tine or on its way: four linear programs."""
    R, t = T_pocket_tine[:3, :3], T_pocket_tine[:3, 3]
    into_tine = np.concatenate([R.T, -R.T[1:]])
    limits = np.array([TIP, TINE[0] / 2, TINE[1] / 2, TINE[0] / 2, TINE[1] / 2])
    bounds = [(0.0, size[0]), (None, None), (None, None)]
    clearance = []
    for axis in (1, 2):
        reached = []
        for sign in (-1.0, 1.0):
            best = linprog(-sign * np.eye(3)[axis], into_tine, limits + into_tine @ t, bounds=bounds)
            if best.status == 2:
                return np.inf, np.inf
            reached.append(-best.fun)
        clearance.append(size[axis] / 2 - max(reached))
    return tuple(clearance)


def test_clearance_to_the_walls_is_that_of_linear_programming():
    for index, (name, (face, D)) in enumerate(EVERY_FACE.items()):
        rng = np.random.default_rng([index, round(1000 * D)])
        number = index % 6  # from small motions to large, in turn
        T = moved(face, random_motion(rng, angle=0.03 + 0.1 * number, offset=0.05 + 0.15 * number))
        slack = docking_slack(T, face)
        clearances = [
            clearance_by_programming(np.linalg.inv(p.T_object_pocket) @ T[0] @ p.T_object_pocket, p.size)
            for p in face.pockets
        ]
        np.testing.assert_allclose(
            [slack.lateral[0], slack.vertical[0]], np.min(clearances, axis=0), atol=1e-7, err_msg=name
        )


def drive(face, T, D, step=0.01, apart=0.02):
    """Push a fork of points along the estimated axis; return the least clearance (m), negative where it failed."""
    rows = [np.linspace(-half, half, 2 + int(2 * half / apart)) for half in (TINE[0] / 2, TINE[1] / 2)]
    along = np.arange(HEEL, TIP + 1e-9, 0.05)
    tine = np.stack(np.meshgrid(along, *rows, indexing="ij"), axis=-1).reshape(-1, 3)
    near = np.inf
    for pocket in face.pockets:
        T_pocket_tine = np.linalg.inv(pocket.T_object_pocket) @ T[0] @ pocket.T_object_pocket
        for short_of in np.arange(1.4, -1e-9, -step):
            points = (tine - [short_of, 0, 0]) @ T_pocket_tine[:3, :3].T + T_pocket_tine[:3, 3]
            inside = points[(points[:, 0] >= 0) & (points[:, 0] <= pocket.size[0])]
            if len(inside):
                near = min(near, (pocket.size[1:] / 2 - np.abs(inside[:, 1:])).min())
        # The pallet is pushed by whatever of the heel is behind its face, and rests on what the tips have under it.
        near = min(near, -points[tine[:, 0] == HEEL, 0].max())
        near = min(near, points[tine[:, 0] == along[-1], 0].min() - 2 / 3 * D)
    return near


@pytest.mark.parametrize("name", ["epal1", "epal6", "gma_48x40"])
def test_a_fork_of_points_docks_where_the_estimate_docks(name):
    model = catalog_object(name)
    rng = np.random.default_rng(3)
    outcomes = []
    for face in docking_faces(model.size, model.pockets):
        D = model.size["xy".index(face.name[1])]
        for _ in range(8):
            T = moved(face, random_motion(rng, angle=0.03, offset=0.06) @ nudge(x=rng.choice([0.0, -0.25])))
            near = drive(face, T, D)
            # Points and steps are so far apart that they miss at most this much of the swept volume.
            if abs(near) > 0.002:
                assert docks(face, T) == (near > 0)
                outcomes.append(near > 0)
    assert len(outcomes) > 20
    assert {True, False} == set(outcomes)


def test_the_estimate_must_be_right_along_the_forks():
    for name, (face, D) in EVERY_FACE.items():
        assert face.depth == pytest.approx(D), name
        short = 1.10 - 2 / 3 * D
        assert docks(face, at_entry(face)), name
        assert docks(face, at_entry(face, x=0.049)), name
        assert not docks(face, at_entry(face, x=0.051)), name
        assert not docks(face, at_entry(face, x=0.2)), name
        assert docks(face, at_entry(face, x=-(short - 0.01))), name
        assert not docks(face, at_entry(face, x=-(short + 0.01))), name
        assert failure(face, at_entry(face, x=0.2)) == "too_deep", name
        assert failure(face, at_entry(face, x=-(short + 0.01))) == "too_short", name


def test_no_symmetry_of_the_pockets_saves_a_pose_that_is_upside_down_or_reversed():
    for name, (face, D) in EVERY_FACE.items():
        level = face.T_object_dock[2, 3]
        for T, wrong in [
            (at_entry(face, roll=np.pi), "upside_down"),
            (at_entry(face, roll=np.pi, z=-2 * level), "upside_down"),
            (at_entry(face, pitch=np.pi, x=D), "upside_down"),
            (at_entry(face, yaw=np.pi), "reversed"),
            (at_entry(face, yaw=np.pi, x=D), "reversed"),
        ]:
            assert not docks(face, T), name
            assert failure(face, T) == wrong, name


def test_a_perfect_estimate_leaves_the_clearance_of_the_epal_drawing():
    slack = docking_slack(at_entry(SHORT_SIDE), SHORT_SIDE)
    assert (slack.lateral[0], slack.vertical[0]) == pytest.approx((0.06375, 0.030))
    assert (slack.heel[0], slack.tips[0]) == pytest.approx((0.05, 1.10 - 0.8))
    assert walls(LONG_SIDE) == pytest.approx((0.14125, 0.030))


@pytest.mark.parametrize("degrees", [0, 1, 2, 3])
def test_lateral_limit_at_the_entry_shrinks_with_yaw(degrees):
    # Turned left, the right tine comes 186 (1 - cos yaw) mm further left; its tip is 1.10 sin(yaw) and half its width
    # of 50 cos(yaw) mm from there.
    yaw = np.deg2rad(degrees)
    limit = 0.11375 - 0.18625 * (1 - np.cos(yaw)) - 1.10 * np.sin(yaw) - 0.050 * np.cos(yaw)
    assert 1000 * limit == pytest.approx([63.75, 44.5, 25.3, 6.0][degrees], abs=0.1)
    assert walls(SHORT_SIDE, yaw=yaw)[0] == pytest.approx(limit)
    assert docks(SHORT_SIDE, at_entry(SHORT_SIDE, yaw=yaw, y=limit - 0.001))
    assert not docks(SHORT_SIDE, at_entry(SHORT_SIDE, yaw=yaw, y=limit + 0.001))


def test_each_offset_uses_up_its_own_slack_on_every_face():
    for face in FACES:
        beside, above = walls(face)
        assert walls(face, y=0.02) == pytest.approx((beside - 0.02, above))
        assert walls(face, y=-0.02) == pytest.approx((beside - 0.02, above))
        assert walls(face, z=0.02) == pytest.approx((beside, above - 0.02))
        assert walls(face, x=0.3) == pytest.approx((beside, above))


def test_the_way_from_the_true_to_the_estimated_entry_is_swept_too():
    # The turn is about a point behind the true entry: there the tine is as far aside as the lever is long.
    pocket, yaw = LONG_SIDE.pockets[0], np.deg2rad(4.0)
    alone = DockingFace("+y", pocket.T_object_pocket, 0.8, (pocket,))
    for behind, lever in [(0.0, 0.8), (0.3, 0.5), (0.6, 0.6)]:
        expected = 0.19125 - lever * np.tan(yaw) - 0.05 / np.cos(yaw)
        assert walls(alone, x=behind, yaw=yaw)[0] == pytest.approx(expected)


def test_the_pocket_limits_how_deep_a_tine_is_swept():
    assert insertion_depth(SHORT_SIDE.pockets[0]) == pytest.approx(1.10)
    assert insertion_depth(LONG_SIDE.pockets[0]) == 0.8
    pitch = np.deg2rad(1.0)
    # 80 cm in, where the lower side of the tine leaves the pallet, it has risen by 0.8 tan(pitch).
    expected = 0.050 - 0.8 * np.tan(pitch) - 0.02 / np.cos(pitch)
    assert walls(LONG_SIDE, pitch=-pitch)[1] == pytest.approx(expected)


def test_a_sloping_heel_touches_with_its_foremost_edge():
    # The tines point down by 3 degrees: the upper edge of their heel is 20 sin(3 deg) mm ahead.
    slack = docking_slack(at_entry(LONG_SIDE, pitch=np.deg2rad(3.0)), LONG_SIDE)
    assert slack.heel[0] == pytest.approx(0.05 * np.cos(np.deg2rad(3.0)) - 0.02 * np.sin(np.deg2rad(3.0)))


def test_a_pallet_taken_for_its_quarter_turn_cannot_be_docked():
    quarter = nudge(yaw=np.pi / 2)[None]
    assert docking_slack(quarter, SHORT_SIDE).lateral[0] < -0.1
    assert not docks(SHORT_SIDE, quarter)


def test_tines_that_stay_outside_touch_no_wall_and_are_too_short():
    T = at_entry(SHORT_SIDE, x=-1.2, y=0.5)
    slack = docking_slack(T, SHORT_SIDE)
    assert slack.lateral[0] == np.inf
    assert failure(SHORT_SIDE, T) == "too_short"


def test_tips_must_reach_into_the_object_however_short_its_pockets_are():
    pocket = SHORT_SIDE.pockets[0]
    blind = DockingFace("-x", pocket.T_object_pocket, 1.2, (replace(pocket, size=np.array([0.5, 0.2275, 0.1])),))
    assert docking_slack(at_entry(blind), blind).tips[0] == pytest.approx(1.10 - 2 / 3 * 1.2)
    assert failure(blind, at_entry(blind, x=-0.31)) == "too_short"


@pytest.mark.parametrize(
    ("motion", "axis"),
    [
        ({"y": 0.08}, "lateral"),
        ({"z": -0.04}, "vertical"),
        ({"yaw": 0.08}, "yaw"),
        ({"pitch": 0.05, "y": 0.01}, "pitch"),
        # The tips rise by 55 mm of the 30 mm above them, and lie 62 mm of the 64 mm aside.
        ({"pitch": 0.05, "y": 0.062}, "pitch"),
        ({"roll": 0.3}, "roll"),
        ({"x": 0.06, "y": 0.06}, "too_deep"),
        ({"x": 0.045, "z": 0.031}, "vertical"),
        ({"x": 0.06, "y": 0.128}, "lateral"),
        ({"x": -0.31}, "too_short"),
    ],
)
def test_the_failure_axis_is_the_error_that_uses_up_most_clearance(motion, axis):
    T = at_entry(SHORT_SIDE, **motion)
    assert not docks(SHORT_SIDE, T)
    assert failure(SHORT_SIDE, T) == axis
