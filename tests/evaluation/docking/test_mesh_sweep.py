import numpy as np
import pytest

from tests.evaluation.pallet import SIZE, nudge, pockets, random_motion
from warehouse_sim.catalog import catalog_object
from warehouse_sim.evaluation.docking.fork import REACH, docking_errors, docking_faces
from warehouse_sim.evaluation.docking.insertion import docking_slack, failure_axes
from warehouse_sim.evaluation.docking.mesh_sweep import FARTHEST, clearance_to_triangles, lane_triangles, mesh_slack
from warehouse_sim.geometry.mesh import TriangleMesh, merge, unit_box
from warehouse_sim.geometry.pose import invert, transform_points

EPAL = catalog_object("epal1")
FACES = {face.name: face for face in docking_faces(EPAL.size, EPAL.pockets)}
MESH = EPAL.mesh()


def box(centre, size) -> TriangleMesh:
    return TriangleMesh(unit_box().vertices * np.array(size) + np.array(centre), unit_box().faces)


def clearance(face, T, mesh=MESH):
    return mesh_slack(np.atleast_3d(T).reshape(-1, 4, 4), face, -0.072, lane_triangles(mesh, face))


def at_entry(face, **motion) -> np.ndarray:
    return face.T_object_dock @ nudge(**motion) @ invert(face.T_object_dock)


def test_a_triangle_beside_a_tine_is_as_far_as_it_is() -> None:
    """The tine is 100 x 40 mm around the x axis of its frame and ends at 1.10 m."""
    for corners, expected in (
        ([[0.5, 0.06, 0.0], [0.6, 0.09, 0.0], [0.5, 0.09, 0.01]], 0.01),
        ([[0.5, 0.0, 0.03], [0.6, 0.0, 0.05], [0.5, 0.01, 0.05]], 0.01),
        ([[0.5, -1.0, 0.025], [0.6, 1.0, 0.025], [0.5, 1.0, 0.025]], 0.005),
        ([[0.5, -1.0, -1.0], [0.5, 1.0, -1.0], [0.5, 0.0, 1.0]], -0.02),
        ([[1.101, -1.0, -1.0], [1.101, 1.0, -1.0], [1.101, 0.0, 1.0]], FARTHEST),
        ([[-9.0, 0.051, -1.0], [-9.0, 0.051, 1.0], [-9.0, 2.0, 0.0]], 0.001),
        # One corner before the tip and far off, the others behind it: only the cut at the tip is near.
        ([[1.0, 0.2, 0.0], [1.2, -0.2, 1.0], [1.2, -0.2, -1.0]], -0.02),
        ([[1.0, 1.0, 0.0], [1.3, -1.0, 0.0], [1.3, -1.0, 0.001]], FARTHEST),
    ):
        got = clearance_to_triangles(np.eye(4)[None], np.array([corners]))
        assert got == pytest.approx([expected], abs=1e-9), corners


def test_points_on_a_triangle_agree() -> None:
    """The slow way: the least over many points of each of many triangles."""
    rng = np.random.default_rng(3)
    weights = rng.dirichlet(np.ones(3), 20_000)
    edges = np.linspace(0, 1, 2000)[:, None]
    weights = np.concatenate([weights, *(np.roll(np.hstack([edges, 1 - edges, 0 * edges]), i, 1) for i in range(3))])
    for _ in range(60):
        triangle = rng.uniform([0.6, -0.15, -0.1], [1.3, 0.15, 0.1], (3, 3))
        points = weights @ triangle
        points = points[points[:, 0] <= REACH]
        slow = (np.abs(points[:, 1:]) - [0.05, 0.02]).max(axis=1).min(initial=FARTHEST)
        got = clearance_to_triangles(np.eye(4)[None], triangle[None])[0]
        assert got <= slow + 1e-12
        assert got == pytest.approx(slow, abs=2e-3)


def test_the_true_pose_leaves_what_the_boards_leave() -> None:
    assert clearance(FACES["-x"], np.eye(4)) == pytest.approx([0.030])
    # The pocket of the long side lies between skids and deck boards; it is measured up to FARTHEST sideways.
    nominal = docking_slack(np.eye(4)[None], FACES["-y"])
    assert clearance(FACES["-y"], np.eye(4)) == pytest.approx(nominal.vertical)


def test_what_clears_the_nominal_pockets_clears_the_new_pallet() -> None:
    rng = np.random.default_rng(0)
    T = np.array([random_motion(rng, 0.04, 0.05) for _ in range(400)])
    for face in FACES.values():
        slack = docking_slack(T, face)
        nominal = np.minimum(slack.lateral, slack.vertical)
        got = clearance(face, T)
        docks = nominal >= 0.0
        assert docks.any()
        # The clearance is measured along the sides of the tine here, of the pocket there: turned by 0.04 rad and more.
        assert (got[docks] >= 0.9 * np.minimum(nominal[docks], FARTHEST)).all()


def test_between_the_skids_there_is_more_clearance_than_the_nominal_pocket() -> None:
    """The long side: skids at the two ends and in the middle; tines that pass below their tops meet them."""
    face = FACES["-y"]
    low = at_entry(face, z=-0.035)
    assert docking_slack(low[None], face).vertical[0] < 0.0
    assert clearance(face, low)[0] < 0.0


def test_a_board_that_stands_out_is_named() -> None:
    bent = merge([MESH, box((0.0, 0.186, -0.03), (0.1, 0.1, 0.03))])
    for face in (FACES["-x"], FACES["+x"]):
        got = clearance(face, np.eye(4), bent)
        slack, errors = docking_slack(np.eye(4)[None], face), docking_errors(np.eye(4)[None], face)
        assert got[0] < 0.0
        assert failure_axes(errors, slack, face, got) == ["board"]
        assert failure_axes(errors, slack, face, -got) != ["board"]


def test_a_tine_beside_the_pallet_or_in_the_next_lane_docks_nothing() -> None:
    for aside in (0.3725, -0.3725, 2.0):
        assert np.isneginf(clearance(FACES["-x"], at_entry(FACES["-x"], y=aside)))


def test_a_tine_in_the_floor_docks_nothing() -> None:
    """Between the skids of the short side there is no board below: 30 mm lower the tines lie on the floor."""
    face = FACES["-x"]
    assert clearance(face, at_entry(face, z=-0.029)) == pytest.approx([0.001])
    assert clearance(face, at_entry(face, z=-0.031)) == pytest.approx([-0.001])


def test_a_quarter_turn_is_a_wrong_face_and_a_half_turn_reversed() -> None:
    face = docking_faces(SIZE, pockets())[0]
    turns = {44.0: None, 46.0: "wrong_face", 89.0: "wrong_face", 91.0: "reversed", 180.0: "reversed"}
    for degrees, name in turns.items():
        T = at_entry(face, yaw=np.deg2rad(degrees))[None]
        slack, errors = docking_slack(T, face), docking_errors(T, face)
        (got,) = failure_axes(errors, slack, face)
        assert (got == name) if name else got not in ("wrong_face", "reversed")
        assert np.isneginf(slack.lateral[0]) == (name is not None)
    T = at_entry(face, roll=np.pi)[None]
    assert failure_axes(docking_errors(T, face), docking_slack(T, face), face) == ["upside_down"]


def test_points_of_a_damaged_pallet_inside_the_swept_tines_are_contact() -> None:
    """The slow way over a whole pallet: dense points of the surface against the prism of each tine."""
    rng = np.random.default_rng(1)
    face = FACES["-x"]
    corners = MESH.vertices[MESH.faces]
    weights = rng.dirichlet(np.ones(3), 1000)
    cloud = np.einsum("kw,mwc->mkc", weights, corners).reshape(-1, 3)
    T = np.array([random_motion(rng, 0.05, 0.05) for _ in range(25)])
    for pose, got in zip(T, clearance(face, T), strict=True):
        touched = False
        for pocket in face.pockets:
            local = transform_points(invert(pose @ pocket.T_object_pocket), cloud)
            inside = (local[:, 0] <= REACH) & (np.abs(local[:, 1]) < 0.05) & (np.abs(local[:, 2]) < 0.02)
            touched |= bool(inside.any())
        if touched:
            assert got < 0.0
