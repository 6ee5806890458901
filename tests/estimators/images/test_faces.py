"""Faces of pallets: boxes by hand against those of labels."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from warehouse_sim.estimators.images.faces import face_labels
from warehouse_sim.estimators.images.letterbox import Letterbox
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import make_transform, rotation_y

LENGTH, WIDTH, HEIGHT, FOCAL, FAR = 1.2, 0.8, 0.144, 400.0, 4.0
CAMERA = PinholeCamera(640, 480, FOCAL, FOCAL, 319.5, 239.5)
BOX = Letterbox.fit((640, 480), (640, 480))
UPRIGHT = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""Object axes in the camera frame: x away from the camera, z up."""


def labels_of(turn: float, mask: np.ndarray, name: str = "pallet", faces: tuple[str, ...] = ()) -> np.ndarray:
    info = SimpleNamespace(
        class_name=name, size=np.array([LENGTH, WIDTH, HEIGHT]), pockets=[SimpleNamespace(face=face) for face in faces]
    )
    target: Any = SimpleNamespace(
        pixels_visible=int(mask.sum()),
        has_pose=True,
        obj_id=7,
        gt_index=0,
        T_camera_object=make_transform(rotation_y(turn) @ UPRIGHT, np.array([0.0, 0.0, FAR])),
        info=lambda objects: info,
    )
    reader: Any = SimpleNamespace(objects={7: info}, mask_visible=lambda image, number: mask)
    image: Any = SimpleNamespace(targets=(target,), camera=CAMERA)
    return face_labels(reader, image, BOX)


EVERYTHING = np.ones((480, 640), dtype=bool)


def test_the_face_ahead_has_the_box_that_its_corners_have() -> None:
    (row,) = labels_of(0.0, EVERYTHING)
    z = FAR - LENGTH / 2
    half = np.array([WIDTH / 2, HEIGHT / 2]) * FOCAL / z
    np.testing.assert_allclose(row[:2], [319.5 - half[0] + 0.5, 239.5 - half[1] + 0.5], atol=1.0)
    np.testing.assert_allclose(row[2:4], [319.5 + half[0] + 0.5, 239.5 + half[1] + 0.5], atol=1.0)
    assert row[4] == -7
    assert row[5] > 0.97
    assert row[6] == pytest.approx(2 * half[1], abs=1.5)


def test_what_is_hidden_of_a_face_is_not_in_its_box() -> None:
    mask = EVERYTHING.copy()
    mask[:, 320:] = False
    (row,) = labels_of(0.0, mask)
    assert row[2] == 320
    assert row[5] == pytest.approx(0.5, abs=0.06)


def test_a_second_face_is_named_and_not_taught() -> None:
    rows = labels_of(np.radians(40), EVERYTHING)
    assert len(rows) == 2
    assert rows[0, 5] > 0.9
    assert rows[1, 5] == 0.0


def test_only_sides_with_pockets_are_faces_and_only_pallets_have_any() -> None:
    (row,) = labels_of(np.radians(60), EVERYTHING, faces=("-x", "+x"))
    front = labels_of(np.radians(60), EVERYTHING)[0]
    assert row[2] - row[0] < front[2] - front[0]
    assert labels_of(0.0, EVERYTHING, name="carton").shape == (0, 8)
