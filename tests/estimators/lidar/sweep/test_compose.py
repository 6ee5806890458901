"""Samples of sweeps: labels stay on what they are about, whatever is done to the sector."""

from pathlib import Path

import numpy as np
import pytest

from tests.estimators.lidar.sweep.test_range_image import GRID
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.lidar.sweep.compose import MARGIN, composed_sweep, plain_sweep
from warehouse_sim.estimators.lidar.sweep.rows import load_sweeps
from warehouse_sim.estimators.lidar.sweep.settings import SweepAugmentConfig
from warehouse_sim.learning.samples.array_store import Arrays

CALM = SweepAugmentConfig(
    window=128, mosaic=0, zoom=1.0, shift=0, flip=0, noise=0, holes=0, floor_unknown=0, floor_error=0
)


@pytest.fixture(scope="module")
def arrays(toy_root: Path) -> Arrays:
    found = load_sweeps(DatasetReader(toy_root), "train", GRID.config, 1, None)
    assert found is not None
    return found


@pytest.mark.parametrize("change", [{}, {"flip": 1.0}, {"zoom": 1.4, "shift": 5.0, "flip": 0.5}, {"mosaic": 1.0}])
def test_the_object_pixels_are_in_the_boxes_and_reach_their_edges(arrays: Arrays, change: dict) -> None:
    config, seen = SweepAugmentConfig(**(vars(CALM) | change)), 0
    for seed in range(30):
        sample = composed_sweep(arrays, seed % 2, config, GRID, np.random.default_rng(seed), True, {1})
        assert sample.depth is not None
        assert sample.depth.shape == (3, 96, 128)
        shows = sample.depth[2] == 1
        inside = np.zeros((96, 128), dtype=bool)
        for left, top, right, bottom, _, fraction, *_ in sample.labels:
            part = np.s_[int(top) : int(np.ceil(bottom)), int(left) : int(np.ceil(right))]
            inside[part] = True
            rows, columns = np.nonzero(shows[part])
            if fraction < 0.99:  # what is left of a box need not be filled
                continue
            assert columns.min() <= 1.5
            assert columns.max() >= (right - left) - 2.5
            assert rows.min() <= 1.5
            seen += 1
        assert not (shows & ~inside).any()
    assert seen > 10


def test_zoom_divides_ranges_and_leaves_heights(arrays: Arrays) -> None:
    whole = plain_sweep(arrays, 0, GRID, {1}).depth
    zoomed = SweepAugmentConfig(**(vars(CALM) | {"zoom": 1.5}))
    ratios = set()
    for seed in range(6):
        rng = np.random.default_rng(seed)
        middle, factor = np.random.default_rng(seed), None
        middle.random()  # whether it is a mosaic
        u0, factor = middle.uniform(0, 256), float(np.exp(middle.uniform(-1, 1) * np.log(1.5)))
        sample = composed_sweep(arrays, 0, zoomed, GRID, rng, True, {1}).depth
        assert whole is not None
        assert sample is not None
        # The sector's middle column is the turn's, rows are scaled about the horizon.
        source = whole[:, :, int(np.floor(u0 + 0.5 / factor)) % 256 + MARGIN]
        rows = np.floor(GRID.horizon + (np.arange(96) + 0.5 - GRID.horizon) / factor).astype(int)
        has = (rows >= 0) & (rows < 96)
        np.testing.assert_allclose(sample[0, has, 64], source[0, rows[has]] / factor, rtol=1e-5)
        np.testing.assert_allclose(sample[1, has, 64], source[1, rows[has]], atol=1e-6)
        ratios.add(round(factor, 3))
    assert len(ratios) == 6


def test_a_whole_turn_shows_its_ends_twice(arrays: Arrays) -> None:
    sample = plain_sweep(arrays, 0, GRID, {1})
    assert sample.depth is not None
    np.testing.assert_array_equal(sample.depth[..., :MARGIN], sample.depth[..., 256 : 256 + MARGIN])
    np.testing.assert_array_equal(sample.depth[..., -MARGIN:], sample.depth[..., MARGIN : 2 * MARGIN])
    labels = sample.labels[sample.labels[:, 5] == 1.0]
    assert {10, 11, 12} == set(sample.labels[:, 7].astype(int))
    for label in labels:
        paired_variant = np.array([256.0, 0, 256, 0])
        if label[2] < 2 * MARGIN + 256 - 256 and label[0] >= 0:
            assert any(np.allclose(other[:4], label[:4] + paired_variant, atol=1e-3) for other in labels)


def test_what_is_cut_has_fewer_points(arrays: Arrays) -> None:
    whole = {label[7]: label for label in plain_sweep(arrays, 0, GRID, {1}).labels if label[5] == 1.0}
    cuts = 0
    for seed in range(40):
        for label in composed_sweep(arrays, 0, CALM, GRID, np.random.default_rng(seed), False, {1}).labels:
            assert label[6] == pytest.approx(whole[label[7]][6] * label[5], rel=1e-4)
            width = whole[label[7]][2] - whole[label[7]][0]
            assert label[5] == pytest.approx((label[2] - label[0]) / width, rel=1e-4)
            cuts += label[5] < 0.99
    assert cuts > 3
