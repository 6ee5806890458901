"""The referee of recorded faces on labels that are made here, and the estimator on the recorded ones."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.benchmark.recorded.entries import dock_of, entries, gravity_of, masked
from warehouse_sim.benchmark.recorded.faces import RecordedFace, drive_in, read_faces
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.geometry.pose import make_transform, rotation_y, rotation_z

T_CAMERA_DOCK = np.array([[0, -1, 0, 0.1], [0, 0, -1, 0.2], [1, 0, 0, 1.5], [0, 0, 0, 1.0]])


def face(tmp_path: Path) -> RecordedFace:
    site = tmp_path / "site"
    site.mkdir()
    depth = np.full((48, 64), 1500, np.uint16)
    cv2.imwrite(str(site / "001_depth.png"), depth)
    cv2.imwrite(str(site / "001_mask.png"), np.pad(np.full((8, 20), 255, np.uint8), 20)[:48, :64])
    centres = [(T_CAMERA_DOCK @ [0, y, 0, 1])[:3].tolist() for y in (0.25, -0.25)]
    label = {
        "frame": 1, "depth": "001_depth.png", "mask": "001_mask.png", "rgb": "001_rgb.jpg",
        "T_camera_dock": T_CAMERA_DOCK.tolist(), "pocket_centres_m": centres,
        "pocket_size_m": [[0.24, 0.10], [0.24, 0.09]], "gravity": [0, 1, 0],
    }  # fmt: skip
    K = [[60, 0, 31.5], [0, 60, 23.5], [0, 0, 1]]
    (site / "labels.json").write_text(json.dumps({"K": K, "frames": [label]}))
    (found,) = read_faces(tmp_path)
    return found


def test_the_ground_truth_docks_with_the_clearance_that_the_labels_leave(tmp_path: Path) -> None:
    entry = drive_in(face(tmp_path), T_CAMERA_DOCK, None)
    assert entry.docked
    assert (entry.clearance_side, entry.clearance_up) == pytest.approx((0.07, 0.025))


@pytest.mark.parametrize(
    ("motion", "docks"),
    [
        ((0.0, 0.06, 0.0, 0.0, 0.0), True),
        ((0.0, 0.08, 0.0, 0.0, 0.0), False),
        ((0.0, 0.0, 0.03, 0.0, 0.0), False),
        ((0.04, 0.0, 0.0, 0.0, 0.0), True),
        ((0.06, 0.0, 0.0, 0.0, 0.0), False),
        ((-0.29, 0.0, 0.0, 0.0, 0.0), True),
        ((-0.31, 0.0, 0.0, 0.0, 0.0), False),
        # The tip is 1.10 m behind the face: 70 mm aside is 3.6 deg, 25 mm up is 1.3 deg.
        ((0.0, 0.0, 0.0, 3.4, 0.0), True),
        ((0.0, 0.0, 0.0, 3.9, 0.0), False),
        ((0.0, 0.0, 0.0, 0.0, 1.2), True),
        ((0.0, 0.0, 0.0, 0.0, 1.4), False),
    ],
)
def test_it_fails_by_hand_computed_margins(tmp_path: Path, motion: tuple[float, ...], docks: bool) -> None:
    x, y, z, yaw, pitch = motion
    turned = rotation_z(np.deg2rad(yaw)) @ rotation_y(-np.deg2rad(pitch))
    T = T_CAMERA_DOCK @ make_transform(turned, np.array([x, y, z]))
    assert drive_in(face(tmp_path), T, None).docked == docks


def test_own_pockets_are_aimed_at(tmp_path: Path) -> None:
    aims = [np.array([-0.25, 0.0]), np.array([0.31, 0.0])]
    entry = drive_in(face(tmp_path), T_CAMERA_DOCK, aims)
    assert entry.docked
    assert entry.clearance_side == pytest.approx(0.01)


def test_a_folder_without_labels_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"labels\.json"):
        read_faces(tmp_path)


def test_disturbances_are_what_their_names_say(tmp_path: Path) -> None:
    item = face(tmp_path)
    off = gravity_of(item, "gt, 0.3 deg off", np.random.default_rng(0))
    assert off is not None
    assert np.degrees(np.arccos(off @ item.gravity)) == pytest.approx(0.3, abs=0.01)
    wide = masked(item.mask, "dilated by 5 px", None).mask
    assert wide is not None
    assert wide.sum() > item.mask.sum()
    assert masked(item.mask, "box", None).mask is None


def test_the_trivial_method_finds_an_exact_rectangle() -> None:
    rng = np.random.default_rng(1)
    local = np.column_stack([np.zeros(3000), rng.uniform(-0.5, 0.5, 3000), rng.uniform(-0.07, 0.07, 3000)])
    T = T_CAMERA_DOCK @ make_transform(rotation_z(0.2), np.zeros(3))
    points = local @ T[:3, :3].T + T[:3, 3]
    for down in (None, np.array([0.0, 1.0, 0.0])):
        assert np.abs(dock_of(points, down, np.random.default_rng(0)) - T).max() < 0.01


@pytest.mark.real
@pytest.mark.parametrize(
    ("masks", "gravity", "least"),
    [
        pytest.param("gt", "none", 13, marks=pytest.mark.slow),
        ("gt", "gt", 14),
        pytest.param("dilated by 5 px", "gt", 13, marks=pytest.mark.slow),
    ],
)
def test_recorded_fronts_are_docked_at(real_data: Path, masks: str, gravity: str, least: int) -> None:
    faces = read_faces(real_data / "pallet_fronts")
    docked = [
        sum(item is not None and item.docked for item in entries(method, {}, faces, masks, gravity))
        for method in (ESTIMATORS.get("front-fit")(), None)
    ]
    assert docked[0] >= max(least, docked[1])
