"""Range images: where directions are, which point a pixel shows, what fills it."""

from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.lidar.projection import read_sweep
from warehouse_sim.estimators.lidar.sweep.range_image import (
    SweepGrid,
    id_boxes,
    range_image,
    ring_overlaps,
)
from warehouse_sim.estimators.lidar.sweep.rows import (
    above_floor,
    floor_of,
    objects_about,
    sweep_labels,
    sweep_rows,
    up_of,
)
from warehouse_sim.estimators.lidar.sweep.settings import RangeImageConfig

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


def test_overlaps_know_no_seam() -> None:
    a = np.array([[250.0, 10, 270, 20]])
    b = np.array([[-6.0, 10, 14, 20], [250, 10, 260, 20], [100, 10, 120, 20]])
    ious, covered = ring_overlaps(a, b, 256)
    np.testing.assert_allclose(ious, [[1.0, 0.5, 0.0]])
    np.testing.assert_allclose(covered, [[1.0, 0.5, 0.0]])


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
