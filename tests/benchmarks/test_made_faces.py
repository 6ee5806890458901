"""Made faces: what is read belongs to their labels."""

import numpy as np
import pytest

from tests.benchmarks.made_faces import made_face
from tests.stored import held
from warehouse_sim.benchmark.entrants.ways import way_of
from warehouse_sim.benchmark.recorded.entries import BASELINE, entries
from warehouse_sim.benchmark.recorded.faces import RecordedFace, drive_in
from warehouse_sim.evaluation.intervals import wilson
from warehouse_sim.geometry.pose import invert, transform_points

COUNT, SEED = 100, 20261127


@pytest.fixture(scope="module")
def faces() -> list[RecordedFace]:
    return [made_face(index, seed=11) for index in range(16)]


def test_a_number_makes_the_same_face_again(faces: list[RecordedFace]) -> None:
    again = made_face(5, seed=11)
    assert np.array_equal(again.depth, faces[5].depth)
    assert np.array_equal(again.T_camera_dock, faces[5].T_camera_dock)
    assert not np.array_equal(again.depth, made_face(5, seed=12).depth)


def test_material_is_read_on_the_face_and_openings_behind_it(faces: list[RecordedFace]) -> None:
    on, behind = [], []
    for face in faces:
        v, u = np.nonzero(face.mask & (face.depth > 0))
        rays = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(face.K).T
        inside = transform_points(invert(face.T_camera_dock), rays * face.depth[v, u][:, None])
        on.append(np.mean(np.abs(inside[:, 0]) < 0.08))
        for centre in face.pockets:
            seen = transform_points(face.T_camera_dock, centre[None])[0]
            u0, v0 = np.rint(face.K @ (seen / seen[2]))[:2].astype(int)
            if 0 <= u0 < face.depth.shape[1] and 0 <= v0 < face.depth.shape[0] and face.depth[v0, u0] > 0:
                behind.append(face.depth[v0, u0] - seen[2])
    # A mask holds posts and decks farther in, too; from above one looks at the floor soon behind the face.
    assert np.median(on) > 0.5
    assert np.median(behind) > 0.2
    assert np.mean(np.array(behind) > 0.05) > 0.8


def test_a_fork_enters_by_the_labels_and_by_a_rectangle_with_gravity(faces: list[RecordedFace]) -> None:
    assert all(drive_in(face, face.T_camera_dock, list(face.pockets[:, 1:])).docked for face in faces)
    found = entries(None, {}, faces, "gt", "gt")
    assert np.mean([entry is not None and entry.docked for entry in found]) > 0.8


@pytest.mark.slow
@pytest.mark.parametrize("method", [BASELINE, "front-fit"])
def test_a_fork_enters_as_many_made_faces_as_is_stored(method: str) -> None:
    estimator = None if method == BASELINE else way_of(method).open({})
    faces = [made_face(index, seed=SEED) for index in range(COUNT)]
    rows = []
    for masks, gravity in (("gt", "none"), ("gt", "gt"), ("box", "none"), ("box", "gt")):
        found = [entry is not None and entry.docked for entry in entries(estimator, {}, faces, masks, gravity)]
        row = {"name": f"{method}, masks: {masks}, gravity: {gravity}", "value": float(np.mean(found))}
        rows.append(row | {"interval": wilson(row["value"], COUNT), "n": COUNT})
    stored = held("made_faces", __file__, rows, data=f"{COUNT} made faces, seed {SEED}")
    for row in rows:
        assert row["value"] == pytest.approx(stored[row["name"]]["value"], abs=0.03), row["name"]
