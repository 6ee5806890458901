"""Boxes of range images, across their ends; floors."""

from pathlib import Path

import numpy as np
import pytest

from tests.estimators.sweep.test_range_image import GRID, directions
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.sweep.boxes import id_boxes, in_box, on_turn, ring_overlaps
from warehouse_sim.estimators.sweep.floor import above_floor, floor_of, up_of
from warehouse_sim.estimators.sweep.range_image import range_image
from warehouse_sim.estimators.sweep.rows import objects_about, read_sweep, sweep_labels, sweep_rows


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


def test_points_are_in_their_own_box_wherever_it_is() -> None:
    points, ids = blobs(np.random.default_rng(9), 5)
    boxes = id_boxes(range_image(points, GRID), ids, np.unique(ids))
    for number, box in zip(np.unique(ids), boxes, strict=True):
        u, v = GRID.places(points).T
        brute = np.zeros(len(points), dtype=bool)
        for turn in (-256, 0, 256):
            brute |= (u + turn >= box[0]) & (u + turn <= box[2]) & (v >= box[1]) & (v <= box[3])
        np.testing.assert_array_equal(in_box(GRID, points, box), brute)
        assert in_box(GRID, points, box)[ids == number].mean() > 0.9
        np.testing.assert_array_equal(in_box(GRID, points, box + np.array([512, 0, 512, 0])), brute)
        np.testing.assert_allclose(on_turn(box + np.array([512, 0, 512, 0]), 256), box)


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
