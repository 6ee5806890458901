"""Upsampling against planted surfaces: no pixel between two of them, planes in closed form, readings held back."""

from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.lidar.upsample import upsample
from warehouse_sim.geometry.camera import PinholeCamera

CAMERA = PinholeCamera(160, 96, 721.5, 721.5, 79.5, 47.5)


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
    rays = CAMERA.rays()
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
