"""Sparse depth against a slow count, and recorded calibration against its own formula."""

from pathlib import Path

import numpy as np
import pytest
from sklearn.cluster import KMeans

from warehouse_sim.dataset.formats.kitti.tolerant import read_calib
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.lidar.pointcloud import kmeans_centres, resample
from warehouse_sim.estimators.lidar.projection import sparse_depth
from warehouse_sim.estimators.lidar.upsample import upsample
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import transform_points

CAMERA = PinholeCamera(60, 40, 50.0, 55.0, 29.0, 19.5)


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
    """KITTI's camera 2 is 6 cm beside the rectified frame; P says so, and the reader by its T_camera_sensor."""
    reader = DatasetReader(real_data / "kitti")
    images = [image for split in reader.splits for image in reader.images(split)]
    assert len(images) == 2
    for image in images:
        path = real_data / "kitti" / "training" / "calib" / f"{image.scene_id:06d}.txt"
        matrices = read_calib(path.read_text(), str(path))
        mounted = reader.sweep(image)
        assert mounted is not None
        points = mounted.reading.points[mounted.reading.points[:, 0] > 3.0].astype(float)
        # x = P R Tr X (Geiger et al. 2013, equation 8).
        in_camera = points @ matrices["Tr_velo_to_cam"][:, :3].T + matrices["Tr_velo_to_cam"][:, 3]
        scaled = in_camera @ matrices["R0_rect"].T @ matrices["P2"][:, :3].T + matrices["P2"][:, 3]
        by_reader = transform_points(mounted.T_camera_sensor, points)
        assert np.abs(scaled[:, 2] - by_reader[:, 2]).max() < 1e-3
        assert np.abs(scaled[:, :2] / scaled[:, 2:] - image.camera.project(by_reader)).max() < 1e-3
        # The reader's depth image is made by other code.
        found = sparse_depth(image.camera, transform_points(mounted.T_camera_sensor, mounted.reading.points))
        same = np.abs(found.depth - reader.depth(image)) < 1e-4
        assert same.mean() > 0.9999
        assert 0.03 < (found.depth > 0).mean() < 0.06


# As many points as asked, and how well they cover: against scikit-learn's K-means.


def cloud(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform([0, 0, 3], [1.2, 0.144, 3.8], (count, 3))


@pytest.mark.parametrize("present", [1, 3, 499, 500, 501, 4000, 20_000])
def test_exactly_as_many_as_requested(present: int) -> None:
    points = cloud(present)
    found = resample(points, 500, np.random.default_rng(1))
    assert found.shape == (500, 3)
    assert np.isfinite(found).all()
    assert len(np.unique(found, axis=0)) == min(present, 500)
    assert (found.min(axis=0) >= points.min(axis=0) - 1e-12).all()
    assert (found.max(axis=0) <= points.max(axis=0) + 1e-12).all()
    again = resample(points, 500, np.random.default_rng(1))
    np.testing.assert_array_equal(found, again)


def test_many_points_at_one_place_are_no_matter() -> None:
    points = np.concatenate([np.zeros((3000, 3)), cloud(40)])
    found = resample(points, 100, np.random.default_rng(0))
    assert found.shape == (100, 3)
    assert np.isfinite(found).all()


def test_few_points_are_all_kept_and_no_points_are_rejected() -> None:
    points = cloud(30)
    found = resample(points, 100, np.random.default_rng(0))
    assert len(found) == 100
    np.testing.assert_array_equal(np.unique(found, axis=0), np.unique(points, axis=0))
    with pytest.raises(ValueError, match="without points"):
        resample(np.zeros((0, 3)), 10, np.random.default_rng(0))


def test_the_centres_are_as_good_as_those_of_scikit_learn() -> None:
    points, rng = cloud(2000), np.random.default_rng(3)
    found = kmeans_centres(points, 256, rng)
    start = points[np.random.default_rng(3).permutation(len(points))[:256]]
    theirs = KMeans(256, init=start, n_init=1, max_iter=10).fit(points).inertia_
    ours = (np.linalg.norm(points[:, None] - found[None], axis=2).min(axis=1) ** 2).sum()
    assert ours < 1.03 * theirs
    random = (np.linalg.norm(points[:, None] - start[None], axis=2).min(axis=1) ** 2).sum()
    assert ours < 0.8 * random


# Upsampling against planted surfaces: no pixel between two of them, planes in closed form, readings held back.


UPSAMPLE_CAMERA = PinholeCamera(160, 96, 721.5, 721.5, 79.5, 47.5)


def sampled(depth: np.ndarray, seed: int = 0, noise: float = 0.0) -> np.ndarray:
    """Keep what a sweep sees: rows about six pixels apart that are not straight, columns about two apart."""
    rng = np.random.default_rng(seed)
    height, width = depth.shape
    sparse = np.zeros((height, width), np.float32)
    for first in np.arange(2.0, height, 6.3):
        u = np.arange(rng.uniform(0, 2.0), width - 1, 2.1) + rng.uniform(-0.3, 0.3)
        v = np.rint(first + 0.004 * (u - width / 2) ** 2 / width * 10).astype(int)
        u = np.clip(np.rint(u).astype(int), 0, width - 1)
        inside = v < height
        sparse[v[inside], u[inside]] = depth[v[inside], u[inside]] * (1 + noise * rng.standard_normal(inside.sum()))
    return sparse


@pytest.mark.parametrize(("near", "far"), [(3.0, 8.0), (2.0, 2.6), (6.0, 20.0), (4.0, 4.7)])
@pytest.mark.parametrize("shape", ["left", "top", "pole", "slanted"])
def test_no_pixel_lies_between_two_surfaces(near: float, far: float, shape: str) -> None:
    v, u = np.mgrid[:96, :160]
    front = {
        "left": u < 70,
        "top": v < 50,
        "pole": np.abs(u - 80) < 8,
        "slanted": u + 0.7 * v < 110,
    }[shape]
    gt = np.where(front, near, far).astype(np.float32)
    dense = upsample(sampled(gt, noise=0.002))
    known = dense > 0
    apart = np.minimum(np.abs(dense - near) / near, np.abs(dense - far) / far)
    assert known[12:-12, 8:-8].all()
    assert (apart[known] > 0.012).sum() == 0, "mixed pixels"
    # The border lies where the readings change: within the distance of two of them.
    wrong = known & ((np.abs(dense - near) < np.abs(dense - far)) != front)
    assert wrong.mean() < 0.025
    inner = np.abs(v - 50) > 6 if shape == "top" else np.ones_like(front)
    columns = {"left": np.abs(u - 69.5) > 2, "pole": np.abs(np.abs(u - 80) - 7.5) > 3}.get(shape, inner)
    if shape in ("left", "top", "pole"):
        assert not (wrong & columns & inner).any()


def test_planes_are_planes() -> None:
    """A floor 1.6 m below the camera and a front turned by 50 deg, in closed form from the pixels' rays."""
    rays = UPSAMPLE_CAMERA.rays()
    steep = PinholeCamera(160, 96, 721.5, 721.5, 79.5, -120.0).rays()
    floor = (1.6 / steep[..., 1]).astype(np.float32)
    turn = np.array([np.sin(np.deg2rad(50)), 0.0, np.cos(np.deg2rad(50))])
    front = (turn[2] * 5.0 / (rays @ turn)).astype(np.float32)
    for gt, bound in ((floor, 0.01), (front, 0.002)):
        dense = upsample(sampled(gt))
        inner = dense[10:-10, 8:-8] / gt[10:-10, 8:-8] - 1.0
        assert (dense[10:-10, 8:-8] > 0).all()
        assert np.abs(inner).max() < bound
        assert abs(inner.mean()) < bound / 5


def test_noise_is_averaged_and_depth_is_not_moved() -> None:
    gt = np.full((96, 160), 5.0, np.float32)
    error = upsample(sampled(gt, noise=0.004))[12:-12, 8:-8] - 5.0
    assert error.std() < 0.5 * 0.004 * 5.0
    assert abs(error.mean()) < 0.002


def test_nothing_grows_over_what_reflects_nothing() -> None:
    gt = np.zeros((96, 160), np.float32)
    gt[30:70, 50:110] = 4.0
    dense = upsample(sampled(gt))
    v, u = np.nonzero(dense)
    assert u.min() >= 50 - 1
    assert u.max() <= 109 + 1
    assert v.min() >= 30
    assert v.max() <= 69
    assert (dense > 0).sum() > 0.7 * (gt > 0).sum()


def test_few_readings_give_no_depth_and_none_gives_none() -> None:
    sparse = np.zeros((40, 50), np.float32)
    assert not upsample(sparse).any()
    sparse[20, 20], sparse[20, 23] = 3.0, 3.0
    assert not upsample(sparse).any()
    sparse[22, 21] = 3.0
    assert upsample(sparse).any()


@pytest.mark.real
def test_recorded_readings_that_were_held_back_are_found_again(real_data: Path) -> None:
    """A tenth of the readings of KITTI's sweeps is taken out; the filter says where they were."""
    reader, rng = DatasetReader(real_data / "kitti"), np.random.default_rng(0)
    for image in [item for split in reader.splits for item in reader.images(split)]:
        sparse = reader.depth(image)
        held = (sparse > 0) & (rng.uniform(size=sparse.shape) < 0.1) & (sparse < 40)
        dense = upsample(np.where(held, np.float32(0.0), sparse))
        known = held & (dense > 0)
        error = np.abs(dense[known] - sparse[known]) / sparse[known]
        assert known.sum() > 0.9 * held.sum()
        assert np.median(error) < 0.005
        # Leaves, fences and the outlines of cars are the rest.
        assert np.quantile(error, 0.8) < 0.03
