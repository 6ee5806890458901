"""Clb against the three products one after the other, and sparse depth against a slow count."""

from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.dataset.formats.kitti.tolerant import read_calib
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.lidar.projection import LidarCalibration, sparse_depth
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_z, transform_points

CAMERA = PinholeCamera(60, 40, 50.0, 55.0, 29.0, 19.5)


def made() -> LidarCalibration:
    P = np.array([[721.5, 0.0, 609.6, 44.9], [0.0, 721.5, 172.9, 0.2], [0.0, 0.0, 1.0, 0.003]])
    axes = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    Tr = np.column_stack([axes @ rotation_z(0.01), [-0.004, -0.08, -0.27]])
    return LidarCalibration(P, rotation_x(0.008), Tr)


def test_clb_is_the_three_steps_one_after_the_other() -> None:
    calibration, rng = made(), np.random.default_rng(0)
    for point in rng.uniform([3, -5, -2], [40, 5, 2], (20, 3)):
        in_camera = calibration.Tr[:, :3] @ point + calibration.Tr[:, 3]
        rectified = calibration.R @ in_camera
        a, b, depth = calibration.P @ np.array([*rectified, 1.0])
        u, v, d = calibration.to_pixels(point[None])[0]
        np.testing.assert_allclose([u, v, d], [a / depth, b / depth, depth], rtol=1e-12)


def test_a_camera_gives_the_same_pixels_by_matrix_and_by_its_own_formula() -> None:
    T = make_transform(rotation_z(0.1) @ rotation_x(-0.2), np.array([0.1, 0.2, 5.0]))
    points = np.random.default_rng(2).uniform(-1, 1, (50, 3))
    found = LidarCalibration.of_camera(CAMERA, T).to_pixels(points)
    in_camera = transform_points(T, points)
    np.testing.assert_allclose(found, np.column_stack([CAMERA.project(in_camera), in_camera[:, 2]]), rtol=1e-12)
    with pytest.raises(InputError, match="no projection matrix"):
        LidarCalibration.of_camera(PinholeCamera(60, 40, 50, 50, 30, 20, Distortion(k1=-0.1)), T)


@pytest.mark.parametrize("lens", [None, Distortion(k1=-0.3, k2=0.1)])
def test_the_nearest_point_of_a_pixel_wins(lens: Distortion | None) -> None:
    camera = PinholeCamera(60, 40, 50.0, 55.0, 29.0, 19.5, lens)
    points = np.random.default_rng(3).uniform([-4, -3, -1], [4, 3, 6], (3000, 3))
    found, expected = sparse_depth(camera, points), np.zeros((40, 60))
    low_x, high_x, low_y, high_y = camera.tangent_bounds()
    for x, y, z in points:
        if z <= 0.1 or not (low_x <= x / z <= high_x and low_y <= y / z <= high_y):
            continue
        u, v = (int(np.floor(value + 0.5)) for value in camera.project(np.array([x, y, z])))
        if 0 <= u < 60 and 0 <= v < 40 and (expected[v, u] == 0 or z < expected[v, u]):
            expected[v, u] = z
    np.testing.assert_array_equal(found.depth, expected.astype(np.float32))
    shown = found.shown >= 0
    np.testing.assert_array_equal(shown, expected > 0)
    np.testing.assert_allclose(points[found.shown[shown], 2], found.depth[shown], rtol=1e-6)


def test_an_empty_sweep_is_an_empty_image() -> None:
    for points in (np.zeros((0, 3)), np.array([[0.0, 0.0, -1.0]])):
        found = sparse_depth(CAMERA, points)
        assert not found.depth.any()
        assert (found.shown == -1).all()


@pytest.mark.real
def test_recorded_calibration_and_the_reader_agree(real_data: Path) -> None:
    """KITTI's camera 2 is 6 cm beside the rectified frame; Clb says so by P, the reader by its T_camera_sensor."""
    reader = DatasetReader(real_data / "kitti")
    images = [image for split in reader.splits for image in reader.images(split)]
    assert len(images) == 2
    for image in images:
        path = real_data / "kitti" / "training" / "calib" / f"{image.scene_id:06d}.txt"
        matrices = read_calib(path.read_text(), str(path))
        by_file = LidarCalibration(matrices["P2"], matrices["R0_rect"], matrices["Tr_velo_to_cam"])
        mounted = reader.sweep(image)
        assert mounted is not None
        points = mounted.reading.points[mounted.reading.points[:, 0] > 3.0].astype(float)
        by_reader = LidarCalibration.of_camera(image.camera, mounted.T_camera_sensor)
        apart = by_file.to_pixels(points) - by_reader.to_pixels(points)
        assert np.abs(apart).max() < 1e-3
        # The reader's depth image is made by other code.
        found = sparse_depth(image.camera, transform_points(mounted.T_camera_sensor, mounted.reading.points))
        same = np.abs(found.depth - reader.depth(image)) < 1e-4
        assert same.mean() > 0.9999
        assert 0.03 < (found.depth > 0).mean() < 0.06
