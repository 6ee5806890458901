"""Range images: where directions are, which point a pixel shows, what fills it."""

from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.lidar.projection import read_sweep
from warehouse_sim.estimators.lidar.sweep.compose import MARGIN, composed_sweep, plain_sweep
from warehouse_sim.estimators.lidar.sweep.range_image import SweepGrid, id_boxes, range_image
from warehouse_sim.estimators.lidar.sweep.rows import (
    above_floor,
    floor_of,
    load_sweeps,
    objects_about,
    sweep_labels,
    sweep_rows,
    up_of,
)
from warehouse_sim.estimators.lidar.sweep.settings import RangeImageConfig, SweepAugmentConfig
from warehouse_sim.learning.samples.array_store import Arrays

GRID = SweepGrid(RangeImageConfig(columns=256, rows=96, elevation_deg=(-25.0, 7.0)))


def directions(elevation: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1).reshape(-1, 3)


def test_pixels_lead_to_directions_and_back() -> None:
    u, v = np.meshgrid(np.arange(256) + 0.5, np.arange(96) + 0.5)
    places = np.stack([u.ravel(), v.ravel()], axis=1)
    rays = GRID.directions(places)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0)
    np.testing.assert_allclose(GRID.places(7.3 * rays), places, atol=1e-9)
    np.testing.assert_array_equal(GRID.pixels(0.4 * rays), np.floor(places).astype(int))
    # Any turn of the image is the same direction.
    np.testing.assert_allclose(GRID.directions(places + np.array([256, 0])), rays, atol=1e-12)


@pytest.mark.parametrize(
    ("point", "u", "v"),
    [
        ((2.0, 0.0, 0.0), 128.0, 21.0),  # ahead, at the horizon: 7 of 32 degrees from the top
        ((0.0, 2.0, 0.0), 64.0, 21.0),  # to the left
        ((0.0, -2.0, 0.0), 192.0, 21.0),
        ((-2.0, 0.0, 0.0), 0.0, 21.0),  # behind, from the left
        ((-2.0, -1e-9, 0.0), 256.0, 21.0),  # behind, from the right
        ((2.0, 0.0, 2.0 * np.tan(np.deg2rad(-9.0))), 128.0, 48.0),
    ],
)
def test_known_directions_are_at_known_pixels(point: tuple[float, float, float], u: float, v: float) -> None:
    np.testing.assert_allclose(GRID.places(np.array([point]))[0], [u, v], atol=1e-6)


def slow(points: np.ndarray) -> np.ndarray:
    """Which point each pixel shows by the definition, one pixel after the other."""
    shown = np.full((96, 256), -1)
    for number, (column, row) in enumerate(GRID.pixels(points)):
        if row >= 0:
            other = shown[row, column]
            if other < 0 or np.linalg.norm(points[number]) < np.linalg.norm(points[other]):
                shown[row, column] = number
    beside = shown.copy()
    for row in range(96):
        if (shown[row] >= 0).mean() > 0.5:
            for column in range(256):
                if shown[row, column] < 0:
                    left, right = shown[row, column - 1], shown[row, (column + 1) % 256]
                    beside[row, column] = left if left >= 0 else right
    gaps = [gap for column in beside.T for gap in np.diff(np.flatnonzero(column >= 0))]
    reach = int(np.ceil(np.percentile(gaps, 75) / 2))
    filled = np.full((96, 256), -1)
    for row in range(96):
        for column in range(256):
            rows = np.flatnonzero(beside[:, column] >= 0)
            if len(rows):
                nearest = rows[np.abs(rows - row).argmin()]
                if abs(nearest - row) <= reach:
                    filled[row, column] = beside[nearest, column]
    return filled


@pytest.mark.parametrize("seed", [0, 1])
def test_each_pixel_shows_what_a_slow_loop_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    beams, steps = np.deg2rad(np.linspace(6.0, -24.0, 20)), np.linspace(-np.pi, np.pi, 300)
    elevation, azimuth = np.meshgrid(beams, steps, indexing="ij")
    rays = directions(
        elevation + rng.normal(0.0, 2e-3, elevation.shape), azimuth + rng.normal(0.0, 3e-3, azimuth.shape)
    )
    points = (rays * rng.uniform(1.0, 30.0, (len(rays), 1)))[rng.permutation(len(rays))[:4500]]
    seen = range_image(points, GRID)
    np.testing.assert_array_equal(seen.shown, slow(points))
    has = seen.shown >= 0
    np.testing.assert_allclose(seen.range[has], np.linalg.norm(points[seen.shown[has]], axis=1), rtol=1e-6)
    assert (seen.range[~has] == 0.0).all()
    assert 0.5 < has.mean() < 1.0


def test_an_empty_sweep_is_an_empty_image() -> None:
    seen = range_image(np.zeros((0, 3)), GRID)
    assert (seen.shown == -1).all()
    assert (seen.range == 0.0).all()
    assert np.isnan(seen.of_points(np.zeros(0), np.nan)).all()


def test_sizes_are_checked() -> None:
    with pytest.raises(ConfigError, match="multiples of 32"):
        RangeImageConfig(columns=1000)
    with pytest.raises(ConfigError, match="must rise"):
        RangeImageConfig(elevation_deg=(5.0, -5.0))


def blobs(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points in windows of directions, each with an id; the first lies across the seam."""
    points, ids = [], []
    for number in range(count):
        azimuth = (np.pi if number == 0 else rng.uniform(-np.pi, np.pi)) + rng.uniform(-0.2, 0.2, 200)
        elevation = rng.uniform(-0.35, 0.0) + rng.uniform(0.0, 0.08, 200)
        points.append(directions(elevation, azimuth) * rng.uniform(2.0, 9.0))
        ids.append(np.full(200, 10 + 3 * number))
    return np.concatenate(points), np.concatenate(ids)


@pytest.mark.parametrize("seed", range(4))
def test_boxes_of_ids_are_those_of_a_search_over_all_stretches(seed: int) -> None:
    points, ids = blobs(np.random.default_rng(seed), 6)
    seen = range_image(points, GRID)
    wanted = np.array([19, 10, 16, 99, 13])
    found = id_boxes(seen, ids, wanted)
    for number, box in zip(wanted, found, strict=True):
        mine = (np.append(ids, 0)[seen.shown] == number) & (seen.shown >= 0)
        if not mine.any():
            assert np.isnan(box).all()
            continue
        rows = np.flatnonzero(mine.any(axis=1))
        assert (box[1], box[3]) == (rows[0], rows[-1] + 1)
        columns = np.flatnonzero(mine.any(axis=0))
        # The shortest stretch that holds them all begins at one of them.
        widths = {int(first): int(((columns - first) % 256).max()) + 1 for first in columns}
        assert box[2] - box[0] == min(widths.values())
        assert box[2] - box[0] == widths[int(box[0])]
    assert np.isnan(found[3]).all()
    assert found[1][0] < 256 < found[1][2], "the first blob lies across the seam"


def test_labels_are_all_that_a_sweep_shows_and_not_what_a_camera_sees(toy_root: Path) -> None:
    reader = DatasetReader(toy_root)
    ahead, behind = (image for image in reader.images("train") if image.scene_id == reader.splits["train"][0])
    assert not behind.targets, "the second camera looks away"
    for image in (ahead, behind):
        scan = read_sweep(reader, image).reading
        labels = sweep_labels(range_image(scan.points, GRID), scan, objects_about(reader, image))
        labels = labels[np.isfinite(labels[:, 0])]
        assert set(labels[:, 7].astype(int)) == {10, 11, 12}
        for label in labels:
            assert label[6] == (scan.instance_ids == label[7]).sum()
            assert (label[4], label[5]) == (1, 1)
    rows = sweep_rows(reader, behind, GRID.config)
    assert rows["obj_id"].shape == (1, 96, 256)
    assert set(np.unique(rows["obj_id"])) == {0, 1}
    # The LiDAR's place over the floor is that of its reading: what shows the floor is 0 above it.
    shows_floor = (rows["obj_id"][0] == 0) & (rows["range_mm"][0] > 0) & (rows["height_mm"][0] < 50)
    assert shows_floor.mean() > 0.5
    assert np.abs(rows["height_mm"][0][shows_floor]).max() < 10


@pytest.mark.parametrize(("slope", "height"), [((0.0, 0.0), -0.9), ((0.02, -0.03), -1.7)])
def test_the_floor_is_the_plane_that_was_made(slope: tuple[float, float], height: float) -> None:
    rng = np.random.default_rng(4)
    xy = rng.uniform(-15, 15, (4000, 2))
    floor = np.column_stack([xy, xy @ slope + height + rng.normal(0, 0.01, 4000)])
    shelf = np.column_stack([rng.uniform(3, 6, (3000, 2)), np.full(3000, -0.3)])
    found = floor_of(np.concatenate([floor, shelf]), rng)
    assert found is not None
    np.testing.assert_allclose(found, [*slope, height], atol=3e-3)
    np.testing.assert_allclose(up_of(found) @ [1, 0, slope[0]], 0.0, atol=3e-3)
    assert above_floor(np.array([[4.0, 4.0, 1.0]]), np.array([0.0, 0.0, -0.5]))[0] == pytest.approx(1.5)
    # A wall alone is no floor, and nothing is not either.
    wall = np.column_stack([np.full(2000, 5.0), rng.uniform(-3, 3, 2000), rng.uniform(-2, -0.1, 2000)])
    assert floor_of(wall, rng) is None
    assert floor_of(np.zeros((0, 3)), rng) is None


# Samples of sweeps: labels stay on what they are about, whatever is done to the sector.


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
