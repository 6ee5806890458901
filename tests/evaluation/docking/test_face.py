"""Docking by a face against docking by the pose that it comes from, and by shifts in closed form."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.evaluation.pallet import SIZE, nudge, pockets, seen_from
from warehouse_sim.dataset.results import pose_csv
from warehouse_sim.dataset.results.predictions import attach_faces, face_path, write_faces
from warehouse_sim.errors import DatasetError
from warehouse_sim.evaluation.docking.fork import approached_face, docking_errors, docking_faces
from warehouse_sim.evaluation.docking.standing import face_columns
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.schema import PalletFace, Pocket, PoseEstimate

FACE_SIZE = np.array([0.9, 1.1, 0.15])
POCKETS = tuple(
    Pocket(face, make_transform(rotation_z(yaw), np.array([sign * 0.45, y, -0.02])), np.array([0.9, 0.30, 0.10]))
    for face, sign, yaw in (("-x", -1.0, 0.0), ("+x", 1.0, np.pi))
    for y in (-0.22, 0.22)
)
T_CAMERA_OBJECT = np.array([[0, -1, 0, 0.1], [0, 0, -1, 0.2], [1, 0, 0, 2.0], [0, 0, 0, 1.0]])


def made_face(shift: tuple[float, float, float] = (0.0, 0.0, 0.0), aside: float = 0.22, yaw: float = 0.0) -> PalletFace:
    T_object_dock = make_transform(rotation_z(yaw), np.array([-0.45, 0.0, -0.02]) + shift)
    return PalletFace(
        T_CAMERA_OBJECT @ T_object_dock,
        np.diag([1e-4, 1e-4, 4e-4, 1e-4, 1e-6, 1e-6]),
        np.array([[-aside, 0.0], [aside, 0.0]]),
        np.tile(np.eye(2) * 1e-6, (2, 1, 1)),
        np.tile([0.30, 0.10], (2, 1)),
        np.tile(np.eye(2) * 4e-6, (2, 1, 1)),
        np.array([1.1, 0.15]),
        np.eye(2) * 1e-6,
    )


def columns(of: PalletFace) -> dict:
    return face_columns(of, T_CAMERA_OBJECT, docking_faces(FACE_SIZE, POCKETS))


def test_the_clearance_is_what_pocket_and_tine_leave() -> None:
    found = columns(made_face())
    assert found["face"] == "-x"
    assert (found["slack_lateral"], found["slack_vertical"]) == pytest.approx((0.10, 0.03))
    assert (found["depth"], found["lateral"], found["yaw"]) == pytest.approx((0.0, 0.0, 0.0))
    moved = columns(made_face((0.02, 0.01, -0.005)))
    assert (moved["depth"], moved["lateral"], moved["vertical"]) == pytest.approx((0.02, 0.01, -0.005))
    assert (moved["slack_lateral"], moved["slack_vertical"]) == pytest.approx((0.09, 0.025))


def test_tines_go_where_the_front_has_its_pockets() -> None:
    assert columns(made_face(aside=0.28))["slack_lateral"] == pytest.approx(0.04)
    assert columns(made_face(aside=0.36))["slack_lateral"] == pytest.approx(-0.04)


def test_a_front_of_another_number_of_pockets_says_nothing() -> None:
    one = made_face()
    fewer = PalletFace(
        one.T_camera_dock, one.covariance, one.pockets[:1], one.pockets_covariance[:1], one.pocket_sizes[:1],
        one.pocket_sizes_covariance[:1], one.size, one.size_covariance,
    )  # fmt: skip
    assert columns(fewer) == {}


def test_the_covariance_of_a_centre_is_that_of_many_moved_frames() -> None:
    made = made_face()
    rng = np.random.default_rng(0)
    motions = rng.multivariate_normal(np.zeros(6), made.covariance, 40_000)
    local = np.array([0.0, 0.22, 0.0])
    moved = local + np.cross(motions[:, :3], local) + motions[:, 3:]
    own = rng.multivariate_normal([0.0, 0.0], made.pockets_covariance[1], 40_000)
    world = (moved + np.pad(own, ((0, 0), (1, 0)))) @ made.T_camera_dock[:3, :3].T
    assert np.cov(world.T) == pytest.approx(made.pocket_centres_covariance[1], rel=0.05, abs=5e-7)
    directions = (np.array([1.0, 0, 0]) + np.cross(motions[:, :3], [1.0, 0, 0])) @ made.T_camera_dock[:3, :3].T
    assert np.cov(directions.T) == pytest.approx(made.direction_covariance, rel=0.05, abs=5e-6)


def test_fronts_lie_beside_the_csv_and_come_back(tmp_path: Path) -> None:
    poses = tmp_path / "poses.csv"
    rows = [
        PoseEstimate(1, 2, 3, 0.9, T_CAMERA_OBJECT),
        PoseEstimate(1, 2, 3, 0.8, T_CAMERA_OBJECT, face=made_face((0.01, 0, 0))),
    ]
    pose_csv.write(poses, rows)
    assert write_faces(poses, rows) == tmp_path / "poses.faces.json"
    plain, with_face = attach_faces(poses, pose_csv.read(poses))
    assert plain.face is None
    assert with_face.face is not None
    assert rows[1].face is not None
    for name in vars(rows[1].face):
        assert np.array_equal(getattr(with_face.face, name), getattr(rows[1].face, name)), name
    told = json.loads((tmp_path / "poses.faces.json").read_text())["faces"][0]
    assert told["direction"] == pytest.approx([0.0, 0.0, 1.0])
    assert told["pocket_centres"][0] == pytest.approx([0.1 + 0.22, 0.22, 1.56])
    # Rows without faces take the file away that would belong to others.
    write_faces(poses, rows[:1])
    assert not face_path(poses).exists()


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda c: c["faces"][0].pop("size"), "the entry 'size' is missing"),
        (lambda c: c["faces"][0].update(size=[1.0]), "size"),
        (lambda c: c["faces"][0].update(size=[1.0, float("nan")]), "NaN"),
        (lambda c: c["faces"][0]["T_camera_dock"][0].__setitem__(0, 2.0), "rigid"),
        (lambda c: c["faces"][0]["covariance"][0].__setitem__(1, 1.0), "symmetric"),
        (lambda c: c["faces"][0].update(row=7), "row 7"),
        (lambda c: c.update(sha256="0"), "other predictions"),
        (lambda c: c.update(faces=3), "faces must be of type list"),
    ],
)
def test_a_broken_file_is_rejected_in_one_line(tmp_path: Path, spoil, message: str) -> None:
    poses = tmp_path / "poses.csv"
    rows = [PoseEstimate(1, 2, 3, 0.8, T_CAMERA_OBJECT, face=made_face())]
    pose_csv.write(poses, rows)
    path = write_faces(poses, rows)
    assert path is not None
    content = json.loads(path.read_text())
    spoil(content)
    path.write_text(json.dumps(content))
    with pytest.raises(DatasetError, match=message) as caught:
        attach_faces(poses, pose_csv.read(poses))
    assert "\n" not in str(caught.value)


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
