"""KITTI files are read here by an implementation of its own, as strict as the strictest of the known readers."""

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.dataset.toy import (
    CAMERA,
    PALLET,
    T_CAMERA_LIDAR,
    failures,
    make_dataset,
    make_manifest,
    make_scene,
    observation_of,
    observe,
)
from warehouse_sim.dataset.formats.kitti.reader import kitti_label, label_line
from warehouse_sim.dataset.formats.kitti.tolerant import read_labels
from warehouse_sim.dataset.formats.kitti.writer import KittiWriter
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import (
    invert,
    level_camera,
    make_transform,
    rotation_y,
    rotation_z,
    transform_points,
)

ROOTS = {0: "training", 1: "training", 2: "testing"}


def frame_file(root: Path, scene: int, observation: int, kind: str, ending: str = "txt") -> Path:
    return root / "kitti" / ROOTS[scene] / kind / f"{2 * scene + observation:06d}.{ending}"


def strict_lines(path: Path) -> list[str]:
    text = path.read_text(encoding="ascii")
    assert text.endswith("\n")
    lines = text[:-1].split("\n")
    assert all(line and line == line.strip() and "  " not in line for line in lines)
    return lines


def read_objects(path: Path) -> list[dict]:
    objects = []
    for line in strict_lines(path):
        words = line.split(" ")
        assert len(words) == 15
        numbers = [float(word) for word in words[3:]]
        objects.append(
            {
                "type": words[0],
                "truncated": float(words[1]),
                "occluded": int(words[2]),
                "alpha": numbers[0],
                "box": numbers[1:5],
                "hwl": numbers[5:8],
                "location": numbers[8:11],
                "rotation_y": numbers[11],
            }
        )
    return objects


def read_calib(path: Path) -> dict[str, np.ndarray]:
    """Read by position, as OpenPCDet does."""
    lines = strict_lines(path)
    assert len(lines) == 7
    names = ["P0", "P1", "P2", "P3", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo"]
    shapes = [(3, 4)] * 4 + [(3, 3)] + [(3, 4)] * 2
    matrices = {}
    for name, shape, line in zip(names, shapes, lines, strict=True):
        words = line.split(" ")
        assert words[0] == name + ":"
        matrices[name] = np.array(words[1:], dtype=np.float64).reshape(shape)
    return matrices


def kitti_corners(label: dict) -> np.ndarray:
    """Return the corners by the development kit's formula, bottom face first."""
    height, width, length = label["hwl"]
    c, s = math.cos(label["rotation_y"]), math.sin(label["rotation_y"])
    Ry = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    x = np.array([1, 1, -1, -1, 1, 1, -1, -1]) * length / 2
    y = np.array([0, 0, 0, 0, -1, -1, -1, -1]) * height
    z = np.array([1, -1, -1, 1, 1, -1, -1, 1]) * width / 2
    return (Ry @ np.array([x, y, z])).T + label["location"]


def same_points(a: np.ndarray, b: np.ndarray, tolerance: float) -> bool:
    distances = np.linalg.norm(a[:, None] - b[None], axis=2)
    return bool(distances.min(axis=0).max() < tolerance and distances.min(axis=1).max() < tolerance)


@pytest.mark.parametrize("scene", [0, 1, 2])
def test_corners_project_to_the_true_corners(toy_root: Path, scene: int) -> None:
    gt = observe(make_scene(scene))[0]
    calib = read_calib(frame_file(toy_root, scene, 0, "calib"))
    labels = read_objects(frame_file(toy_root, scene, 0, "label_2"))
    for label, annotation in zip(labels, gt.annotations, strict=True):
        expected = transform_points(annotation.T_camera_object, box_corners(PALLET.size))
        corners = kitti_corners(label)
        assert same_points(corners, expected, 1e-5)
        homogeneous = np.hstack([corners, np.ones((8, 1))]) @ calib["P2"].T
        assert same_points(homogeneous[:, :2] / homogeneous[:, 2:], CAMERA.project(expected), 1e-3)


@pytest.mark.parametrize("scene", [0, 1, 2])
def test_all_fields_are_real(toy_root: Path, scene: int) -> None:
    gt = observe(make_scene(scene))[0]
    labels = read_objects(frame_file(toy_root, scene, 0, "label_2"))
    for label, annotation in zip(labels, gt.annotations, strict=True):
        assert label["type"] == "pallet"
        assert label["hwl"] == [0.144, 0.8, 1.2]
        assert label["truncated"] == pytest.approx(1 - annotation.pixels_in_image / annotation.pixels_all, abs=1e-4)
        fraction = annotation.pixels_visible / annotation.pixels_in_image
        assert label["occluded"] == (0 if fraction >= 0.9 else 1 if fraction >= 0.5 else 2)
        x, _, z = annotation.T_camera_object[:3, 3]
        expected_alpha = label["rotation_y"] - math.atan2(x, z)
        assert abs(math.remainder(label["alpha"] - expected_alpha, 2 * math.pi)) < 2e-6
        left, top, right, bottom = annotation.box_amodal_xyxy
        assert label["box"] == [max(left, 0), max(top, 0), min(right, 159), min(bottom, 95)]
    assert [label["truncated"] > 0 for label in labels] == [False, False, True]
    assert [label["occluded"] for label in labels] == [1, 0, 0]


def test_image_without_labels_has_one_dont_care_row(toy_root: Path) -> None:
    (row,) = read_objects(frame_file(toy_root, 0, 1, "label_2"))
    assert row["type"] == "DontCare"
    assert (row["truncated"], row["occluded"], row["alpha"]) == (-1, -1, -10)
    assert row["hwl"] == [-1, -1, -1]
    assert row["location"] == [-1000, -1000, -1000]


def test_lidar_points_project_onto_the_object_that_they_hit(toy_root: Path) -> None:
    gt = observe(make_scene(0))[0]
    calib = read_calib(frame_file(toy_root, 0, 0, "calib"))
    cloud = np.fromfile(frame_file(toy_root, 0, 0, "velodyne", "bin"), dtype="<f4").reshape(-1, 4)
    ids = np.fromfile(frame_file(toy_root, 0, 0, "velodyne_ids", "bin"), dtype="<i4")
    assert np.array_equal(cloud[:, :3], gt.lidar.points)
    assert np.array_equal(cloud[:, 3], gt.lidar.intensity)
    assert np.array_equal(ids, gt.lidar.instance_ids)
    beams = np.fromfile(frame_file(toy_root, 0, 0, "velodyne_beams", "bin"), dtype="<f4").reshape(-1, 2)
    assert np.array_equal(beams[:, 0], gt.lidar.ring)
    assert np.array_equal(beams[:, 1], gt.lidar.time)
    own = np.hstack([cloud[ids == 11, :3], np.ones((np.count_nonzero(ids == 11), 1))])
    camera_points = own @ calib["Tr_velo_to_cam"].T @ calib["R0_rect"].T
    uvw = np.hstack([camera_points, np.ones((len(own), 1))]) @ calib["P2"].T
    u, v = np.rint(uvw[:, 0] / uvw[:, 2]).astype(int), np.rint(uvw[:, 1] / uvw[:, 2]).astype(int)
    # The LiDAR stands elsewhere than the camera, so that a few points look past an edge.
    assert len(own) > 20
    assert (gt.buffers.instance_mask[v, u] == 11).mean() > 0.8


def test_depth_and_plane(toy_root: Path) -> None:
    gt = observe(make_scene(0))[0]
    steps = cv2.imread(str(frame_file(toy_root, 0, 0, "depth_2", "png")), cv2.IMREAD_UNCHANGED)
    assert steps.dtype == np.uint16
    assert np.abs(steps / 256.0 - gt.rgbd.depth).max() <= 0.5 / 256 + 1e-6
    lines = strict_lines(frame_file(toy_root, 0, 0, "planes"))
    assert [float(word) for word in lines[3].split(" ")] == pytest.approx([0, -1, 0, 0.9], abs=1e-9)
    assert len(lines) == 4


def test_colour_image_is_bops_own_file(toy_root: Path) -> None:
    assert frame_file(toy_root, 0, 0, "image_2", "png").samefile(toy_root / "bop/train/000000/rgb/000000.png")


@pytest.mark.parametrize("heading", np.linspace(-np.pi, np.pi, 17)[1:])
def test_label_describes_any_heading(heading: float) -> None:
    annotation = observe(make_scene(0))[0].annotations[0]
    upright = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    T_camera_object = make_transform(rotation_y(heading) @ upright, np.array([-2.0, 0.7, 5.0]))
    label = kitti_label(replace(annotation, T_camera_object=T_camera_object), CAMERA, "here")
    assert np.abs(label.T_camera_object() - T_camera_object).max() < 1e-12
    (found,) = read_labels(label_line(label), "here")
    assert found.rotation_y == pytest.approx(label.rotation_y, abs=1e-6)
    assert "-0.00 " not in label_line(label) + " "


def two_words(observation):
    first, *others = observation.annotations
    return replace(observation, annotations=(replace(first, class_name="euro pallet"), *others))


def too_deep(observation):
    depth = observation.rgbd.depth.copy()
    depth[0, 0] = 256.5
    return observation.with_reading("camera", replace(observation.rgbd, depth=depth))


def pitched(pitch: float = 0.0, roll: float = 0.0):
    T_world_camera = level_camera(np.array([0.0, 0.0, 0.9]), 0.0, pitch, roll)
    return lambda observation: observation_of(make_scene(0), 0, T_world_camera)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (pitched(pitch=math.radians(-5)), "the camera is tilted by 5.00 deg, KITTI needs a level camera"),
        (pitched(roll=math.radians(0.2)), "the camera is tilted by 0.20 deg"),
        (lambda observation: observation.with_reading("lidar", None), "there is no LiDAR; give the recipe one"),
        (two_words, "the class name 'euro pallet' must be one word"),
        (too_deep, "depth 256.500 m does not fit into 16 bits"),
    ],
)
def test_what_kitti_cannot_hold_is_rejected(tmp_path: Path, change, message: str) -> None:
    writer = KittiWriter(tmp_path, make_manifest())
    writer.begin([PALLET], CAMERA)
    with pytest.raises(DatasetError) as caught:
        writer.scene(make_scene(0)).write(ObservationFiles(change(observe(make_scene(0))[0])))
    assert message in str(caught.value)
    assert str(caught.value).startswith("KITTI, scene 0, observation 0: ")
    assert not any(path.is_file() for path in (tmp_path / "kitti" / "training").rglob("*"))


def test_yawed_camera_and_lidar_are_fine(tmp_path: Path) -> None:
    writer = KittiWriter(tmp_path, make_manifest())
    writer.begin([PALLET], CAMERA)
    T_world_camera = level_camera(np.array([0.5, 0.2, 1.3]), 0.3)
    T_camera_lidar = T_CAMERA_LIDAR @ make_transform(rotation_z(0.7))
    observation = observation_of(make_scene(0), 0, T_world_camera)
    turned = observation.with_reading("lidar", observation.lidar, T_camera_lidar)
    writer.scene(make_scene(0)).write(ObservationFiles(turned))
    calib = read_calib(tmp_path / "kitti" / "training" / "calib" / "000000.txt")
    assert np.abs(calib["Tr_velo_to_cam"] - T_camera_lidar[:3]).max() < 1e-12
    corners = [
        kitti_corners(label) for label in read_objects(tmp_path / "kitti" / "training" / "label_2" / "000000.txt")
    ]
    for instance, points in zip(make_scene(0).target_instances(), corners, strict=False):
        in_world = transform_points(T_world_camera, points)
        expected = transform_points(instance.T_world_object, box_corners(PALLET.size))
        assert same_points(in_world, expected, 1e-5)
        assert np.abs(invert(T_world_camera)[1, :2]).max() == 0


@pytest.mark.parametrize(
    "line",
    [
        "pallet 0 0 0 1 1 2 2 1 1 1 0 0 5",
        "pallet  0 0 0 1 1 2 2 1 1 1 0 0 5 0",
        "pallet 0 1.0 0 1 1 2 2 1 1 1 0 0 5 0",
        "pallet 0 0 0 1 1 2 2 1 1 1 0 0 5 0\n",
    ],
)
def test_rows_that_strict_readers_reject_are_named(tmp_path: Path, line: str) -> None:
    root = make_dataset(tmp_path / "data", make_manifest(formats=("kitti",)))
    (root / "kitti/training/label_2/000000.txt").write_text(f"{line}\n")
    assert "15 fields with single blanks are expected" in failures(root)["kitti labels"]
